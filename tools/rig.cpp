#include <cmath>
#include <iostream>
#include <memory>
#include <optional>

#include "controller/policy.hpp"
#include "controller/realtime.hpp"
#include "controller/rig/driver.hpp"
#include "controller/rig/rig_file.hpp"
#include "controller/rig/wiring.hpp"
#include "controller/start_check.hpp"
#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "core/files/whole_file.hpp"
#include "msgs/stop_signal.hpp"
#include "report/table.hpp"
#include "tools/given_files.hpp"
#include "tools/json.hpp"
#include "tools/patience.hpp"
#include "tools/verbs.hpp"

namespace stillframe::tools {

namespace {

using namespace controller;

struct RigOptions {
  std::filesystem::path gains;
  std::optional<std::filesystem::path> rig, out;
  std::string io;
  std::optional<double> force_n;
  bool json = false;
};

Json to_json(const SignalFinding& signal, const Gains& gains) {
  if (signal.cable < 0) return {{"cable", nullptr}, {"gain", nullptr}};
  return {{"cable", gains.legs[static_cast<std::size_t>(signal.cable)]}, {"gain", signal.gain}};
}

void print_json(const Wiring& wiring, const Probe& probe, const RigFile& rig, const Gains& gains) {
  Json legs = Json::array();
  for (const LegFinding& leg : wiring.legs) {
    legs.push_back({{"leg", leg.leg},
                    {"sigma", to_json(leg.sigma, gains)},
                    {"applied", to_json(leg.applied, gains)},
                    {"force", to_json(leg.force, gains)},
                    {"delay_samples", leg.delay_samples},
                    {"gain_doubt", leg.doubt},
                    {"rest_mean_n", leg.sigma_mean},
                    {"rest_noise_n", leg.sigma_noise},
                    {"wrong", leg.wrong}});
  }
  print({{"rig", rig.title},
         {"driver", rig.driver},
         {"sound", wiring.sound},
         {"mended", wiring.mended},
         {"clock_ppm", -1e6 * probe.drift},
         {"n_samples", probe.n_samples},
         {"n_lost", probe.n_lost},
         {"legs", legs}});
}

void print_page(const Wiring& wiring, const Probe& probe, const RigFile& rig, const Gains& gains) {
  std::cout << rig.title << ": driver " << rig.driver
            << formatted(", %lld samples, %lld lost, clock %+.1f ppm\n\n",
                         static_cast<long long>(probe.n_samples),
                         static_cast<long long>(probe.n_lost), -1e6 * probe.drift);
  const auto shown = [&](const SignalFinding& signal, const std::string& leg) {
    if (signal.cable < 0) return std::string("silent");
    const std::string& cable = gains.legs[static_cast<std::size_t>(signal.cable)];
    return formatted("%+.4f", signal.gain) + (cable == leg ? "" : " on " + cable);
  };
  report::Table table({"leg", "force sensor", "read-back", "amplifier", "+-", "late by samples",
                       "at rest N", "noise N"},
                      1);
  for (const LegFinding& leg : wiring.legs) {
    table.add({leg.leg, shown(leg.sigma, leg.leg), shown(leg.applied, leg.leg),
               shown(leg.force, leg.leg), formatted("%.1g", leg.doubt),
               formatted("%+.2f", leg.delay_samples), formatted("%.4g", leg.sigma_mean),
               formatted("%.2g", leg.sigma_noise)});
  }
  std::cout << table.print() << "\n";
  for (const LegFinding& leg : wiring.legs) {
    for (const std::string& what : leg.wrong) std::cout << leg.leg << ": " << what << "\n";
  }
  if (wiring.sound) {
    std::cout << "Every leg answers as the rig file and the gains say.\n";
  } else if (wiring.mended) {
    std::cout << "The rig file can put all of it right.\n";
  } else {
    std::cout << "No rig file can put all of it right.\n";
  }
}

int run(const RigOptions& options) {
  require_own_places({{"the gains file", options.gains}, {"the rig file", options.rig}},
                     {{"--out", options.out}});
  const Gains gains = read_gains(options.gains);
  RigFile rig = options.rig ? read_rig(*options.rig, gains) : default_rig(gains);
  choose_driver(rig, options.io);
  const ProbeSettings settings =
      probe_settings(gains, rig.channels, probe_force(options.force_n, gains, options.gains));
  // As the loop that will stand here: a probe behind other programs' turns loses its windows. Where
  // the system does not give it, it goes on without.
  prepare_thread(default_policy(gains.sample_rate_hz).priority, std::nullopt);
  const LoadedIo io = load_driver(rig.driver, rig.setting(gains));
  ScaledIo scaled(*io, rig.channels);
  catch_stop_signals();
  Probe probe;
  {
    Patience patience("probing");
    try {
      probe = probe_rig(
          scaled, gains.n_legs(), settings, real_time(),
          [&](double done) { patience.now("probing", 100 * done); }, stop_requested);
    } catch (const std::runtime_error& error) {
      throw Failure(std::string("the rig could not be probed: ") + error.what());
    }
  }
  const Wiring wiring = wiring_of(probe, settings, gains, rig.channels);
  options.json ? print_json(wiring, probe, rig, gains) : print_page(wiring, probe, rig, gains);
  if (options.out && wiring.mended) {
    RigFile mended = rig;
    mended.channels = wiring.channels;
    write_whole_file(*options.out, to_yaml(mended, gains));
  }
  return wiring.sound ? exit_done : exit_failed;
}

}  // namespace

void add_rig(cli::Command& app, int& exit_code) {
  auto options = std::make_shared<RigOptions>();
  cli::Command verb = app.verb(
      "rig", "Probe a rig before its loop is closed: cables, signs, gains and delay of each leg");
  verb.option("gains", options->gains, "Gains file, as `design` writes it")
      .required()
      .type_name("GAINS");
  verb.option("rig", options->rig, "Rig file (docs/hardware.md); without one, --io is needed")
      .type_name("RIG");
  verb.option("--io", options->io,
              "Driver: simulation, device, or a shared library (default: the rig file's)")
      .type_name("NAME");
  verb.option("--force", options->force_n,
              "N, peak of the force on a leg (default: 2 % of the force limit)")
      .check(cli::positive_number());
  verb.option("--out", options->out, "Write a rig file that puts right what was found, if one can")
      .type_name("FILE");
  verb.flag("--json", options->json, "Print JSON (keys below)");
  verb.footer(
      "One leg after the other is driven by a small multisine from 0.2 to 0.42 of the sample rate, "
      "where\n"
      "the inertia of the frame holds it still and a leg answers with its own force; what answers "
      "is\n"
      "compared with the plant of the gains. It takes 1600 samples a leg. Nothing else may close a "
      "loop\n"
      "meanwhile. The probe lets go of a rig whose forces go beyond ten times its own.\n"
      "An amplifier on another cable is told from a force sensor and a read-back that are both on "
      "it by\n"
      "nothing; it is the amplifier that is named.\n"
      "Exit codes: 0 all as it should be; 4 something is wrong, or the rig could not be probed.\n"
      "Keys of --json:\n"
      "  rig, driver, sound, mended   mended: a rig file can put all of it right\n"
      "  clock_ppm, n_samples, n_lost\n"
      "  legs   {leg, sigma, applied, force, delay_samples, gain_doubt, rest_mean_n, rest_noise_n, "
      "wrong};\n"
      "         sigma, applied, force: {cable (the leg whose channel it is on), gain (1: as the "
      "rig file\n"
      "         says)}, null where nothing answers; wrong: texts\n"
      "Example: stillframe rig gains.yaml rig.yaml --out mended.yaml");
  verb.runs([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace stillframe::tools
