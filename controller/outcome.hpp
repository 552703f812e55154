#pragma once

namespace stillframe::controller {

/// How a run ended, as seen by the controller.
enum class Outcome {
  ended,         ///< the plant said so
  plant_failed,  ///< the plant said so
  missed,        ///< it had ended before its start was heard
  silent,        ///< nothing was heard for the time limit
  interrupted,   ///< SIGINT or SIGTERM
  began_anew,    ///< the plant was started again, or another one
  refused,       ///< another controller serves the run
};

}  // namespace stillframe::controller
