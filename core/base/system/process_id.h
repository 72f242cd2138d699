// The cached process id, without a system call each time.
#pragma once

namespace skybody {

/// Same as getpid(). Updated in the child after a fork() of the C library.
int process_id();

}  // namespace skybody
