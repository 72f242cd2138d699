#include "crazyflie_stub.h"
