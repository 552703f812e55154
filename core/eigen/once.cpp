#define STILLFRAME_EIGEN_ONCE
#include "core/eigen/once.hpp"
