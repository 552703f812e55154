#include "controller/rig/rig_file.hpp"

#include <algorithm>
#include <cmath>

#include "core/yaml/quoted.hpp"
#include "core/yaml/reader.hpp"
#include "msgs/identity.hpp"

namespace stillframe::controller {

namespace {

constexpr std::int64_t most_channels = 1024;

std::vector<Channel> in_order(std::size_t n) {
  std::vector<Channel> channels(n);
  for (std::size_t i = 0; i < n; ++i) channels[i].number = static_cast<Eigen::Index>(i);
  return channels;
}

Channel read_channel(const YamlReader& entry, std::size_t place) {
  entry.allow_only({"channel", "gain", "tare"});
  Channel channel{.number = static_cast<Eigen::Index>(place)};
  if (const auto value = entry.find("channel")) {
    channel.number = value->integer(0);
    if (channel.number >= most_channels) {
      value->fail("found " + value->text() + ", allowed is a whole number from 0 to " +
                  std::to_string(most_channels - 1));
    }
  }
  if (const auto value = entry.find("gain")) {
    channel.gain = value->number();
    if (!(std::abs(channel.gain) >= smallest_number))
      value->fail("found 0, allowed is any other number");
  }
  if (const auto value = entry.find("tare")) channel.tare = value->number();
  return channel;
}

void refuse_twice(const YamlReader& block, const std::vector<Channel>& channels,
                  const std::vector<std::string>& names) {
  for (std::size_t i = 0; i < channels.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (channels[i].number != channels[j].number) continue;
      block.require(names[i]).fail("channel " + std::to_string(channels[i].number) +
                                   " is that of " + names[j] + " too");
    }
  }
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

void note_place(RigFile& rig, const YamlReader& value) {
  rig.places[value.name()] = value.place() + ": " + value.name();
}

/// Of the legs, by their names: all of them, each on a channel of its own.
void read_legs(const YamlReader& rig, const char* key, const std::vector<std::string>& legs,
               std::vector<Channel>& channels) {
  const auto block = rig.find(key);
  if (!block) return;
  for (const auto& [name, entry] : block->entries()) {
    const auto leg = std::ranges::find(legs, name);
    if (leg == legs.end()) {
      const std::string near = nearest_name(name, legs);
      entry.fail("is no leg of the gains" +
                 (near.empty() ? "" : " (did you mean '" + near + "'?)") + "; allowed are " +
                 listed(legs));
    }
    const auto place = static_cast<std::size_t>(leg - legs.begin());
    channels[place] = read_channel(entry, place);
  }
  for (const std::string& leg : legs) block->require(leg);
  refuse_twice(*block, channels, legs);
  for (std::size_t i = 0; i < legs.size(); ++i) {
    if (channels[i].number < static_cast<Eigen::Index>(legs.size())) continue;
    block->require(legs[i]).fail("channel " + std::to_string(channels[i].number) + ": there are " +
                                 std::to_string(legs.size()) + ", from 0");
  }
}

void read_named(const YamlReader& reader, const char* key, RigFile& rig,
                std::vector<std::string>& names, std::vector<Channel>& channels) {
  const auto block = reader.find(key);
  if (!block) return;
  names.clear();
  channels.clear();
  for (const auto& [name, entry] : block->entries()) {
    channels.push_back(read_channel(entry, names.size()));
    names.push_back(name);
    note_place(rig, entry);
  }
  refuse_twice(*block, channels, names);
}

}  // namespace

void choose_driver(RigFile& rig, const std::string& io) {
  if (!io.empty()) {
    rig.driver = io;
    rig.places["driver"] = "--io";
  }
  if (!rig.driver.empty()) return;
  const std::string place = rig.place_of(rig.places.contains("driver") ? "driver" : "");
  throw InputError((place.empty() ? "" : place + ": ") +
                   "no driver: name one in a rig file, as in driver: {name: device, from: samples, "
                   "to: commands}, or with --io");
}

std::string RigFile::place_of(const std::string& name) const {
  const auto found = places.find(name);
  return found == places.end() ? name : found->second;
}

DriverSetting RigFile::setting(const Gains& gains) const {
  std::map<std::string, std::string> said_by;
  for (const auto& [name, value] : options) said_by[name] = place_of("driver." + name);
  return {.n_legs = gains.n_legs(),
          .n_floor = n_channels(channels.floor),
          .n_frame = n_channels(channels.frame),
          .sample_rate_hz = gains.sample_rate_hz,
          .gains = &gains,
          .options = options,
          .folder = folder,
          .said_by = place_of("driver"),
          .options_said_by = std::move(said_by)};
}

RigFile default_rig(const Gains& gains) {
  RigFile rig;
  // By it a latch is kept, which is none of another frame's business.
  rig.title = "rig of scene " + gains.scene_hash;
  rig.channels.sigma = rig.channels.applied = rig.channels.force = in_order(gains.legs.size());
  rig.floor = gains.heard_floor();
  rig.channels.floor = in_order(rig.floor.size());
  return rig;
}

RigFile read_rig(const std::filesystem::path& path, const Gains& gains) {
  const YamlReader reader = YamlReader::from_file(path);
  reader.allow_only({"title", "scene", "driver", "sigma", "applied", "force", "floor", "frame"});
  RigFile rig = default_rig(gains);
  rig.folder = reader.folder();
  rig.places[""] = path.string();
  if (const auto title = reader.find("title")) rig.title = title->text();
  if (const auto scene = reader.find("scene")) {
    constexpr std::size_t largest_scene = 100'000'000;
    rig.scene = scene->text();
    rig.scene_text = scene->file_bytes(largest_scene).second;
  }
  if (const auto driver = reader.find("driver")) {
    if (!driver->is_map()) {
      driver->fail(
          "found no map, allowed is one, as in {name: device, from: samples, to: commands}");
    }
    for (const auto& [name, value] : driver->entries()) {
      (name == "name" ? rig.driver : rig.options[name]) = value.text();
      note_place(rig, value);
    }
    // Of a driver of one's own nobody knows.
    if (rig.driver == "device") driver->allow_only({"name", "from", "to"});
    if (rig.driver == "simulation") driver->allow_only({"name", "floor_rms"});
    note_place(rig, *driver);
  }
  read_legs(reader, "sigma", gains.legs, rig.channels.sigma);
  read_legs(reader, "applied", gains.legs, rig.channels.applied);
  read_legs(reader, "force", gains.legs, rig.channels.force);
  read_named(reader, "floor", rig, rig.floor, rig.channels.floor);
  read_named(reader, "frame", rig, rig.frame, rig.channels.frame);
  if (const auto& heard = gains.heard_floor(); !heard.empty() && rig.floor != heard) {
    reader.require("floor").fail("found " + listed(rig.floor) + ", allowed is " + listed(heard) +
                                 ": what the law hears, in its order");
  }
  return rig;
}

std::string to_yaml(const RigFile& rig, const Gains& gains) {
  std::string text = "title: " + quoted(rig.title) + "\n";
  if (!rig.scene.empty()) text += "scene: " + quoted(rig.scene) + "\n";
  if (!rig.driver.empty()) {
    text += "driver: {name: " + quoted(rig.driver);
    for (const auto& [name, value] : rig.options) text += ", " + name + ": " + quoted(value);
    text += "}\n";
  }
  const auto add = [&](const char* key, const std::vector<std::string>& names,
                       const std::vector<Channel>& channels) {
    if (names.empty()) return;
    text += std::string(key) + ":\n";
    for (std::size_t i = 0; i < names.size(); ++i) {
      text += "  " + quoted(names[i]) + ": {channel: " + std::to_string(channels[i].number) +
              ", gain: " + shortest_digits(channels[i].gain) +
              ", tare: " + shortest_digits(channels[i].tare) + "}\n";
    }
  };
  add("sigma", gains.legs, rig.channels.sigma);
  add("applied", gains.legs, rig.channels.applied);
  add("force", gains.legs, rig.channels.force);
  add("floor", rig.floor, rig.channels.floor);
  add("frame", rig.frame, rig.channels.frame);
  return text;
}

stillframe_msgs::run_info_t describe_rig(const RigFile& rig, const Gains& gains,
                                         const std::string& gains_text, std::int64_t run_id,
                                         std::int64_t n_samples, const std::string& version) {
  stillframe_msgs::run_info_t info;
  info.run_id = run_id;
  info.plant_instance = new_instance();
  info.format_version = 1;
  info.program_version = version;
  info.scene_name = rig.title;
  info.scene_hash = gains.scene_hash;
  info.scene_text = rig.scene_text;
  info.gains_text = gains_text;
  info.mode = "wall_clock";
  info.loop = "active";
  info.sample_rate_hz = gains.sample_rate_hz;
  info.delay_samples = gains.delay_samples;
  info.n_samples = n_samples;
  info.floor_names = rig.floor;
  info.leg_names = gains.legs;
  info.frame_names = rig.frame;
  info.n_floor = static_cast<std::int32_t>(rig.floor.size());
  info.n_legs = static_cast<std::int32_t>(gains.legs.size());
  info.n_frame = static_cast<std::int32_t>(rig.frame.size());
  return info;
}

}  // namespace stillframe::controller
