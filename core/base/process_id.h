// Which process this is, without asking the system every time.
#pragma once

namespace skybody {

/// As getpid(). After a fork() of the C library the child sees its own.
int process_id();

}  // namespace skybody
