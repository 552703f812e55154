// A template, never run on a device: converters that Linux has as IIO, by libiio 0. `adc` and `dac`
// of the rig file name devices; `sigma`, `floor`, `frame`, `force` list their channels (voltage0
// voltage1), in counts; `idle` is the count of no force. Rate and trigger are set before
// (iio_attr).
#include <iio.h>

#include "controller/rig/sampling_io.hpp"

using namespace stillframe::controller;

class IioDriver : public SamplingIo {
 public:
  explicit IioDriver(const DriverSetting& rig) : SamplingIo(rig, rig.list<int>("idle", 1)[0]) {
    const auto there = [](auto* found, const std::string& what) {
      return found ? found : throw std::runtime_error(what + ": " + std::strerror(errno));
    };
    context_.reset(there(iio_create_local_context(), "IIO"));
    iio_context_set_timeout(context_.get(), 50);  // ms that a refill waits
    errno = ENODEV;
    auto* adc = there(iio_context_find_device(context_.get(), rig.option("adc").c_str()), "adc");
    auto* dac = there(iio_context_find_device(context_.get(), rig.option("dac").c_str()), "dac");
    for (const std::string& id : inputs<std::string>(rig)) {
      iio_channel* channel = there(iio_device_find_channel(adc, id.c_str(), false), "adc: " + id);
      in_.push_back(there(iio_channel_is_scan_element(channel) ? channel : nullptr, id));
      iio_channel_enable(channel);
    }
    for (const std::string& id : rig.list<std::string>("force", rig.n_legs))
      out_.push_back(there(iio_device_find_channel(dac, id.c_str(), true), "dac: " + id));
    buffer_.reset(there(iio_device_create_buffer(adc, 1, false), "adc"));
    start();
  }
  ~IioDriver() override { stop(); }

 private:
  Wait wait_for_sample(std::span<double> readings) noexcept override {
    const ssize_t n = iio_buffer_refill(buffer_.get());
    if (n <= 0) return n == -ETIMEDOUT ? Wait::none : Wait::failed;
    for (std::size_t i = 0; i < in_.size(); ++i) {
      std::int64_t raw = 0;  // of which libiio fills the bytes that a sample has
      iio_channel_convert(in_[i], &raw, iio_buffer_first(buffer_.get(), in_[i]));
      const auto* format = iio_channel_get_data_format(in_[i]);
      if (format->is_signed) raw = raw << (64 - format->length) >> (64 - format->length);
      readings[i] = static_cast<double>(raw);
    }
    return Wait::sample;
  }
  bool write(std::span<double> force) noexcept override {
    bool taken = true;
    for (std::size_t i = 0; i < out_.size(); ++i) {
      force[i] = std::round(force[i]);
      taken &= iio_channel_attr_write_longlong(out_[i], "raw", std::llround(force[i])) == 0;
    }
    return taken;
  }

  std::unique_ptr<iio_context, void (*)(iio_context*)> context_{nullptr, iio_context_destroy};
  std::unique_ptr<iio_buffer, void (*)(iio_buffer*)> buffer_{nullptr, iio_buffer_destroy};
  std::vector<iio_channel*> in_, out_;
};
STILLFRAME_DRIVER(IioDriver)
