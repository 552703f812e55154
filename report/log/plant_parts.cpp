#include "report/log/plant_parts.hpp"

#include <algorithm>
#include <map>

#include "core/errors/input_error.hpp"
#include "msgs/channels.hpp"
#include "msgs/identity.hpp"
#include "report/log/event_file.hpp"
#include "stillframe_msgs/measurement_t.hpp"
#include "stillframe_msgs/run_info_t.hpp"

namespace stillframe::report {

using stillframe_msgs::measurement_t;
using stillframe_msgs::run_info_t;

namespace {

/// As many as make a clock that was set believed (seq_clock.hpp): damage does not agree so often.
constexpr std::int64_t enough = 16;
/// A damaged log may name any number of plants that are none.
constexpr std::size_t most_plants = 1000;

struct Tally {
  PlantPart part;
  std::int64_t last_seq = -1, last_at = -1;  ///< of its newest measurement: seq, place in the log

  bool is_plant() const {
    return part.n_samples > 0 && (part.described || part.n_samples >= enough);
  }
};

class Tallies {
 public:
  explicit Tallies(std::int64_t run_id) : run_id_(run_id) {}

  void take(const LogEvent& event, std::int64_t at) {
    if (event.channel == channels::measurement) {
      if (fit<measurement_t>(event.payload) == Fit::whole) count(event.payload, at);
    } else if (event.channel == channels::run_info) {
      run_info_t info;
      if (decode(event.payload, info) && info.run_id == run_id_) {
        tally_of(info.plant_instance).part.described = true;
      }
    }
  }

  std::vector<PlantPart> plants() const {
    std::vector<Tally> found;
    for (const auto& [instance, tally] : tallies_) {
      if (tally.is_plant()) found.push_back(tally);
    }
    std::sort(found.begin(), found.end(),
              [](const Tally& a, const Tally& b) { return a.last_at < b.last_at; });
    std::vector<PlantPart> parts;
    for (const Tally& tally : found) parts.push_back(tally.part);
    return parts;
  }

 private:
  void count(std::string_view payload, std::int64_t at) {
    const auto identity = identity_of(payload);
    if (!identity || identity->run_id != run_id_) return;
    Tally& tally = tally_of(identity->plant_instance);
    const std::int64_t seq = read_int64(&payload[32]);  // behind the identity
    // The plant of a lock-step run repeats its newest measurement until it is answered.
    if (seq != tally.last_seq) ++tally.part.n_samples;
    tally.last_seq = seq;
    tally.last_at = at;
  }

  Tally& tally_of(std::int64_t instance) {
    if (tallies_.size() >= most_plants && !tallies_.contains(instance)) {
      std::erase_if(tallies_, [](const auto& entry) { return !entry.second.is_plant(); });
    }
    Tally& tally = tallies_[instance];
    tally.part.instance = instance;
    return tally;
  }

  std::int64_t run_id_;
  std::map<std::int64_t, Tally> tallies_;
};

}  // namespace

std::vector<PlantPart> plants_of_run(const std::filesystem::path& log, std::int64_t run_id,
                                     const std::function<void(double)>& progress) {
  constexpr std::int64_t tell_every = std::int64_t{16} << 20;
  EventFile file(log);
  Tallies tallies(run_id);
  LogEvent event;
  std::int64_t told = 0;
  while (file.next(event)) {
    tallies.take(event, file.position());
    if (progress && file.position() - told >= tell_every) {
      told = file.position();
      progress(static_cast<double>(told) / static_cast<double>(file.size()));
    }
  }
  return tallies.plants();
}

std::size_t choose_plant(const std::vector<PlantPart>& plants, std::optional<int> wanted,
                         std::int64_t run_id, const std::string& place) {
  const auto is_described = [](const PlantPart& plant) { return plant.described; };
  const bool any_described = std::any_of(plants.begin(), plants.end(), is_described);
  if (wanted) {
    const auto n = std::max<std::size_t>(plants.size(), 1);
    if (*wanted < 1 || static_cast<std::size_t>(*wanted) > n) {
      throw InputError(place + ": plant: found " + std::to_string(*wanted) + ", run " +
                       std::to_string(run_id) + " has " + std::to_string(n) +
                       (n == 1 ? " plant" : " plants, counted from 1"));
    }
    const auto chosen = static_cast<std::size_t>(*wanted - 1);
    if (any_described && !plants[chosen].described) {
      throw InputError(place + ": plant " + std::to_string(*wanted) + " of run " +
                       std::to_string(run_id) + " has no " + channels::run_info +
                       " message, so its samples cannot be read");
    }
    return chosen;
  }
  if (!any_described) return plants.empty() ? 0 : plants.size() - 1;
  const auto last = std::find_if(plants.rbegin(), plants.rend(), is_described);
  return static_cast<std::size_t>(plants.rend() - last) - 1;
}

std::string plants_in_words(const std::vector<PlantPart>& plants, std::size_t chosen,
                            std::int64_t run_id) {
  if (plants.size() < 2) return {};
  std::string text = "run " + std::to_string(run_id) + " was measured by " +
                     std::to_string(plants.size()) + " plants:";
  for (std::size_t i = 0; i < plants.size(); ++i) {
    text += (i == 0 ? " plant " : ", plant ") + std::to_string(i + 1) + " " +
            std::to_string(plants[i].n_samples) +
            (plants[i].n_samples == 1 ? " sample" : " samples");
    if (!plants[i].described) text += " without " + std::string(channels::run_info);
  }
  return text + "; those of plant " + std::to_string(chosen + 1) +
         " are read and no others (--plant chooses)";
}

}  // namespace stillframe::report
