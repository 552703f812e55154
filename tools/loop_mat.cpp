#include "tools/loop_mat.hpp"

#include "controller/law.hpp"
#include "core/control/continuous_loop.hpp"
#include "core/control/open_plant.hpp"
#include "core/control/own_law.hpp"
#include "report/export/mat_file.hpp"

namespace stillframe::tools {

using Eigen::Index;
using Eigen::MatrixXd;
using report::MatFile;

namespace {

/// Names and units that stand side by side.
struct NamesAndUnits {
  MatFile::Texts names, units;

  void add(const std::vector<std::string>& more, const std::string& unit,
           const std::string& prefix = "") {
    for (const std::string& name : more) names.push_back(prefix + name);
    units.insert(units.end(), more.size(), unit);
  }
};

void add_system(MatFile& file, const std::string& name, const LinearSystem& system,
                double sample_time, const NamesAndUnits& inputs, const NamesAndUnits& outputs) {
  file.add_struct(name, {{"A", system.A},
                         {"B", system.B},
                         {"C", system.C},
                         {"D", system.D},
                         {"Ts", MatrixXd(MatrixXd::Constant(1, 1, sample_time))},
                         {"input_names", inputs.names},
                         {"input_units", inputs.units},
                         {"output_names", outputs.names},
                         {"output_units", outputs.units}});
}

/// The continuous plant from (w, u) to (y, sigma).
LinearSystem plant_system(const LoopPlant& plant) {
  const Index n = plant.A.rows(), p = plant.B_w.cols(), m = plant.B_u.cols();
  const Index n_y = plant.C_y.rows();
  LinearSystem system{plant.A, MatrixXd(n, p + m), MatrixXd(n_y + m, n), MatrixXd(n_y + m, p + m)};
  system.B << plant.B_w, plant.B_u;
  system.C << plant.C_y, plant.C_sigma;
  system.D << plant.D_yw, plant.D_yu, MatrixXd::Zero(m, p), MatrixXd::Identity(m, m);
  return system;
}

/// A sampled loop from (w, v) to y.
LinearSystem with_noise(const SampledLoop& loop) {
  LinearSystem system{loop.A, MatrixXd(loop.A.rows(), loop.B.cols() + loop.B_v.cols()), loop.C,
                      MatrixXd(loop.C.rows(), loop.D.cols() + loop.D_v.cols())};
  system.B << loop.B, loop.B_v;
  system.D << loop.D, loop.D_v;
  return system;
}

/// The first n of a model's inputs or outputs.
NamesAndUnits first_of(const std::vector<SignalInfo>& signals, Index n) {
  NamesAndUnits result;
  for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
    result.add({signals[i].name}, signals[i].unit);
  }
  return result;
}

}  // namespace

void write_loop_mat(const judge::LoopDesign& design, const std::filesystem::path& path) {
  const MatFile::Texts& legs = design.gains.legs;
  const LinearModel& model = design.loop.plant;
  const NamesAndUnits floor = first_of(model.inputs, design.loop.n_w);
  const NamesAndUnits motion = first_of(model.outputs, design.loop.n_y);
  NamesAndUnits forces, errors, floor_forces = floor, floor_noise = floor, motion_stresses = motion;
  const DiscreteLaw law = controller::law_from_gains(design.gains);
  forces.add(legs, "N", "force:");
  const bool filtered = law.applied_memory > 0;
  errors.add(legs, "N",
             !law.subtract_applied ? sigma_prefix
             : filtered            ? "filtered_strain_force:"
                                   : strain_prefix);
  if (law.hears_applied()) errors.add(legs, "N", applied_prefix);
  floor_forces.add(legs, "N", "force:");
  floor_noise.add(legs, "N", "sensor_noise:");
  motion_stresses.add(legs, "N", "sigma:");

  MatFile file(path);
  file.add_text("scene", design.scene.title);
  file.add_text("scene_hash", design.scene.hash);
  file.add("leg_names", legs);
  if (!design.runs_own_law()) {
    file.add("K_P", design.gains.K_P);
    file.add("K_I", design.gains.K_I);
  }
  add_system(file, "plant", plant_system(design.settings.plant), 0, floor_forces, motion_stresses);
  add_system(file, "loop", continuous_loop(design.settings.plant, design.loop.gains), 0,
             floor_noise, motion);
  add_system(file, "open", {design.open.A, design.open.B, design.open.C, design.open.D},
             design.open.sample_time, floor, motion);
  add_system(file, "closed", with_noise(design.closed), design.closed.sample_time, floor_noise,
             motion);
  add_system(file, "law", {law.A, law.B, law.C, law.D}, design.gains.sample_time(), errors, forces);
  if (law.feed_forward.D.cols() > 0) {
    add_system(file, "feed_forward", law.feed_forward, design.gains.sample_time(), floor, forces);
  }
  NamesAndUnits answers = motion, heard;
  answers.add(legs, "N", sigma_prefix);
  answers.add(legs, "N", applied_prefix);
  answers.add(floor.names, "m/s^2", floor_prefix);
  add_system(file, "sampled_plant", open_plant(design.sampled), design.gains.sample_time(),
             floor_forces, answers);
  const NamedLaw whole = named(law, legs, floor.names);
  for (const std::string& name : whole.inputs) {
    heard.add({name}, name.starts_with(floor_prefix) ? "m/s^2" : "N");
  }
  add_system(file, "whole_law", {whole.A, whole.B, whole.C, whole.D}, design.gains.sample_time(),
             heard, forces);
  file.save();
}

}  // namespace stillframe::tools
