#pragma once

namespace stillframe {

/// Whether a motion could go on, by whatever formulation and method.
enum class MotionStatus {
  ok,
  equations_failed,  ///< they cannot be evaluated at some position near the present one
  too_many_steps,    ///< within one part of a sample
  failed,            ///< the method itself gave up
};

}  // namespace stillframe
