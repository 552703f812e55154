#include "report/live/listener.hpp"

#include "msgs/clock.hpp"
#include "msgs/lcm_bus.hpp"

namespace stillframe::live {

namespace {

// A second and more of measurements and commands, while a copy is made.
constexpr int queue_capacity = 8192;

}  // namespace

class Listener::Handler {
 public:
  explicit Handler(Listener& listener) : listener_(listener) {}

  void on_message(const lcm::ReceiveBuffer* buffer, const std::string& channel) {
    const std::string_view bytes(static_cast<const char*>(buffer->data), buffer->data_size);
    const std::lock_guard lock(listener_.mutex_);
    listener_.watcher_.take(channel, bytes, monotonic_ns());
  }

 private:
  Listener& listener_;
};

Listener::Listener(const std::string& url, WatchSettings settings)
    : lcm_(open_lcm(url)),
      watcher_(std::move(settings), monotonic_ns()),
      handler_(std::make_unique<Handler>(*this)) {
  require_hearing(*lcm_);
  lcm_->subscribe("SF_.*", &Handler::on_message, handler_.get())->setQueueCapacity(queue_capacity);
  thread_ = std::jthread([this](const std::stop_token& stop) {
    while (!stop.stop_requested()) handle_one(*lcm_, 100);
  });
}

Listener::~Listener() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

BusWatcher Listener::heard() const {
  const std::lock_guard lock(mutex_);
  return watcher_;
}

}  // namespace stillframe::live
