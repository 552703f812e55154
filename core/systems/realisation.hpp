#pragma once

namespace stillframe {

/// How a force feedback law is sampled.
enum class Realisation {
  implicit_feedthrough,  ///< the applied force is taken out of sigma first (THEORY fact 3)
  naive_pi,              ///< the law on sigma itself: unstable, kept to be shown and refused
};

}  // namespace stillframe
