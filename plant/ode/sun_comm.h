// SUN_COMM_NULL is the communicator of a process alone, for SUNContext_Create(): SUNDIALS 7 defines it, 6
// takes a null pointer.
#pragma once

#include <cvode/cvode.h>

#ifndef SUN_COMM_NULL
#define SUN_COMM_NULL nullptr
#endif
