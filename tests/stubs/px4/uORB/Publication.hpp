#include "px4_stub.hpp"
