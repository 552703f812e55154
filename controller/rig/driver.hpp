#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "controller/gains.hpp"
#include "controller/io.hpp"
#include "core/errors/input_error.hpp"

namespace stillframe::controller {

/// What a driver is told: how many channels there are, and its options of the rig file.
struct DriverSetting {
  Eigen::Index n_legs = 0;   ///< channels of sigma, applied and force
  Eigen::Index n_floor = 0;  ///< accelerations of the floor
  Eigen::Index n_frame = 0;  ///< accelerations of the frame
  double sample_rate_hz = 0;
  const Gains* gains = nullptr;
  std::map<std::string, std::string> options;  ///< driver: of the rig file, but for its name
  std::filesystem::path folder;                ///< of the rig file, for paths among them
  /// How messages call the driver and each of its options: "rig.yaml:2:9: driver", or "--io".
  std::string said_by = "driver";
  std::map<std::string, std::string> options_said_by;

  // Inline, since the library of a driver has nothing of stillframe but its headers.

  /// Of an option. Errors: InputError that says so, with the place of that option.
  [[noreturn]] void fail(const std::string& name, const std::string& message) const {
    const auto at = options_said_by.find(name);
    throw InputError((at == options_said_by.end() ? said_by + ": " + name : at->second) + ": " +
                     message);
  }

  /// An option that has to be there. Errors: InputError.
  const std::string& option(const std::string& name) const {
    const auto found = options.find(name);
    if (found == options.end()) {
      fail(name, "missing, required by this driver; options stand under driver of a rig file");
    }
    return found->second;
  }

  /// An option that lists n channels, as in `sigma: 0 1 2`, as whole numbers or names; none if n is
  /// 0. Errors: InputError.
  template <class Item>
  std::vector<Item> list(const std::string& name, Eigen::Index n) const {
    const std::string text = n > 0 ? option(name) : "";
    std::istringstream words(text);
    std::vector<Item> found;
    for (Item item; words >> item;) found.push_back(item);
    if (found.size() == static_cast<std::size_t>(n) && words.eof()) return found;
    fail(name, "found '" + text + "', allowed is a list of " + std::to_string(n) +
                   ", with blanks between");
  }
};

/// An Io and the library that it came from.
class LoadedIo {
 public:
  LoadedIo(std::shared_ptr<void> library, std::unique_ptr<Io> io)
      : library_(std::move(library)), io_(std::move(io)) {}
  Io& operator*() const { return *io_; }

 private:
  std::shared_ptr<void> library_;  ///< outlives its Io
  std::unique_ptr<Io> io_;
};

/// The driver of that name: simulation, device, or the path of a shared library that has
/// STILLFRAME_DRIVER. Set-up. Errors: InputError, and what the driver throws.
LoadedIo load_driver(const std::string& name, const DriverSetting& setting);

}  // namespace stillframe::controller

/// Makes a class, an Io constructed from a DriverSetting, a driver in a shared library of its own.
#define STILLFRAME_DRIVER(Class)                              \
  extern "C" stillframe::controller::Io* stillframe_make_io(  \
      const stillframe::controller::DriverSetting& setting) { \
    return new Class(setting);                                \
  }
