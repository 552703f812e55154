#include "tools/batch_rows.hpp"

namespace stillframe::tools {

namespace {

Json identity_of(const StudyCase& study, std::optional<double> duration_s) {
  Json row{{"version", STILLFRAME_VERSION},
           {"scene_file", study.scene.string()},
           {"scene_hash", nullptr},
           {"controller_file", study.controller ? study.controller->string() : ""},
           {"floor_file", study.floor ? study.floor->string() : ""},
           {"floor_hash", nullptr},
           {"duration_s", duration_s ? Json(*duration_s) : Json()}};
  try {
    const StudyHashes hashes = hashes_of(study);
    row["scene_hash"] = hashes.scene;
    row["floor_hash"] = hashes.floor;
  } catch (const std::exception&) {
    // Said by who runs it.
  }
  return row;
}

Json row_of(const StudyCase& study, std::optional<double> duration_s) {
  // Before it runs: what is changed on the way is not what ran.
  Json row = identity_of(study, duration_s);
  StudyResult result = run_case(study, duration_s);
  if (result.failure.empty() && identity_of(study, duration_s) != row) {
    result.failure = "its scene, floor or recordings were changed while it ran";
  }
  if (!result.failure.empty()) {
    row["failure"] = result.failure;
    return row;
  }
  row["outcome"] = report::to_text(result.verdict.judgement.outcome);
  row["reason"] = result.verdict.judgement.reason;
  row["method"] = result.method;
  row["n_samples"] = result.n_samples;
  row["peak_force_n"] = result.peak_force;
  row["rms_force_n"] = result.rms_force;
  row["n_saturated"] = result.verdict.runs.back().n_saturated;
  row["real_time_factor"] = result.times_real_time;
  row["axes"] = Json::array();
  for (const auto& axis : result.verdict.axes) {
    row["axes"].push_back(
        {{"axis", axis.axis},
         {"floor_rms_m_s2", axis.floor ? Json(axis.floor->rms_acceleration) : Json(nullptr)},
         {"passive_rms_m_s2", axis.passive->rms_acceleration},
         {"active_rms_m_s2", axis.active->rms_acceleration},
         {"active_vibration_class", axis.active->vibration_class}});
  }
  return row;
}

}  // namespace

const RowKind batch_rows{"batch",
                         {"version", "scene_file", "scene_hash", "controller_file", "floor_file",
                          "floor_hash", "duration_s"},
                         {}};

RowStudy batch_study(const std::vector<StudyCase>& cases, std::optional<double> duration_s) {
  return {.things = "runs",
          .n_points = cases.size(),
          .identity = [&, duration_s](std::size_t i) { return identity_of(cases[i], duration_s); },
          .answers = [](const Json& row) { return !row.contains("failure"); },
          .compute = [&, duration_s](std::size_t i) { return row_of(cases[i], duration_s); }};
}

}  // namespace stillframe::tools
