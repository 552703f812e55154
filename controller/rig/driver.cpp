#include "controller/rig/driver.hpp"

#include <dlfcn.h>

#include "controller/rig/device_io.hpp"
#include "controller/rig/simulated_io.hpp"

namespace stillframe::controller {

LoadedIo load_driver(const std::string& name, const DriverSetting& setting) {
  if (name == "simulation") return {nullptr, std::make_unique<SimulatedIo>(setting)};
  if (name == "device") return {nullptr, std::make_unique<DeviceIo>(setting)};
  if (name.find('/') == std::string::npos && !name.ends_with(".so")) {
    throw InputError(setting.said_by + ": found '" + name +
                     "', allowed are simulation, device and the path of a shared library");
  }
  const std::string path = (setting.folder / name).lexically_normal().string();
  const std::string found = path.find('/') == std::string::npos ? "./" + path : path;
  const std::shared_ptr<void> library(dlopen(found.c_str(), RTLD_NOW | RTLD_LOCAL),
                                      [](void* handle) {
                                        if (handle != nullptr) dlclose(handle);
                                      });
  if (!library) throw InputError(setting.said_by + ": " + dlerror());
  using Make = Io*(const DriverSetting&);
  auto* make = reinterpret_cast<Make*>(dlsym(library.get(), "stillframe_make_io"));
  if (make == nullptr)
    throw InputError(setting.said_by + ": " + path + ": is no driver, has no STILLFRAME_DRIVER");
  // What a driver throws has its code in the library, so it may not outlive it.
  std::string said;
  try {
    return {library, std::unique_ptr<Io>(make(setting))};
  } catch (const InputError& error) {
    said = error.what();
  } catch (const std::exception& error) {
    said = setting.said_by + ": " + path + ": " + error.what();
  }
  throw InputError(said);
}

}  // namespace stillframe::controller
