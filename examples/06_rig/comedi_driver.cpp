// A template, never run on a device: a card that comedilib knows. `device` of the rig file is its
// file; `sigma`, `floor`, `frame`, `force` list channels of its first analogue inputs and outputs,
// in counts, on the ranges numbered `in_range`, `out_range`; `idle` is the count of no force.
#include <comedilib.h>

#include <algorithm>

#include "controller/rig/sampling_io.hpp"

using namespace stillframe::controller;

class ComediDriver : public SamplingIo {
 public:
  explicit ComediDriver(const DriverSetting& rig) : SamplingIo(rig, rig.list<int>("idle", 1)[0]) {
    const auto require = [&rig](bool good, const char* what) {
      const std::string said = std::string(what) + comedi_strerror(comedi_errno());
      if (!good) throw std::runtime_error(rig.option("device") + ": " + said);
    };
    card_.reset(comedi_open(rig.option("device").c_str()));
    require(card_ != nullptr, "");
    ai_ = static_cast<unsigned>(comedi_find_subdevice_by_type(card_.get(), COMEDI_SUBD_AI, 0));
    ao_ = static_cast<unsigned>(comedi_find_subdevice_by_type(card_.get(), COMEDI_SUBD_AO, 0));
    for (const int channel : inputs<int>(rig))
      in_.push_back(CR_PACK(channel, rig.list<int>("in_range", 1)[0], AREF_GROUND));
    for (const int channel : rig.list<int>("force", rig.n_legs))
      out_.push_back(CR_PACK(channel, rig.list<int>("out_range", 1)[0], AREF_GROUND));
    comedi_cmd scans{};
    const unsigned n = unsigned(in_.size()), ns = unsigned(1e9 / rig.sample_rate_hz);
    require(comedi_get_cmd_generic_timed(card_.get(), ai_, &scans, n, ns) == 0, "timed scans: ");
    require(std::abs(1.0 * scans.scan_begin_arg / ns - 1) < 1e-3, "cannot keep the sample rate: ");
    scans.chanlist = in_.data(), scans.chanlist_len = n;
    scans.stop_src = TRIG_NONE, scans.stop_arg = 0;
    scans.flags |= TRIG_WAKE_EOS;  // each scan as soon as it is complete
    require(comedi_command(card_.get(), &scans) == 0, "scans: ");
    start();
  }
  ~ComediDriver() override { stop(); }

 private:
  Wait wait_for_sample(std::span<double> readings) noexcept override {
    const bool wide = comedi_get_subdevice_flags(card_.get(), ai_) & SDF_LSAMPL;
    const int file = comedi_fileno(card_.get());
    return wide ? wait_for<lsampl_t>(file, readings) : wait_for<sampl_t>(file, readings);
  }
  bool write(std::span<double> force) noexcept override {
    bool taken = true;
    for (std::size_t i = 0; i < out_.size(); ++i) {
      const unsigned c = CR_CHAN(out_[i]), range = CR_RANGE(out_[i]);
      const double most = comedi_get_maxdata(card_.get(), ao_, c);
      force[i] = std::clamp(std::round(force[i]), 0.0, most);
      taken &= comedi_data_write(card_.get(), ao_, c, range, AREF_GROUND, lsampl_t(force[i])) == 1;
    }
    return taken;
  }

  std::unique_ptr<comedi_t, int (*)(comedi_t*)> card_{nullptr, comedi_close};
  unsigned ai_ = 0, ao_ = 0;
  std::vector<unsigned> in_, out_;
};
STILLFRAME_DRIVER(ComediDriver)
