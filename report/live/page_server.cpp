#include "report/live/page_server.hpp"

#include <httplib.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string_view>
#include <thread>

#include "core/errors/input_error.hpp"
#include "report/live/page_connection.hpp"
#include "report/live/page_parts.hpp"

namespace stillframe::live {

using namespace std::chrono_literals;

namespace {

constexpr const char* address = "127.0.0.1";
// Beside the streams, for whoever asks for the page.
constexpr std::size_t n_threads = PageServer::most_streams + 8;
constexpr auto write_timeout = 2s;
constexpr RequestLimits request_limits{.bytes = 8192, .read = 2s, .write = write_timeout};
// A stream says something at least so often, so that a browser that has gone is noticed.
constexpr auto longest_silence = 5s;

using View = std::shared_ptr<const std::string>;

/// The newest view, and who waits for the next one.
class Board {
 public:
  void put(View view) {
    {
      const std::lock_guard lock(mutex_);
      view_ = std::move(view);
      ++number_;
    }
    changed_.notify_all();
  }

  void close() {
    {
      const std::lock_guard lock(mutex_);
      closed_ = true;
    }
    changed_.notify_all();
  }

  View newest() const {
    const std::lock_guard lock(mutex_);
    return view_;
  }

  bool closed() const {
    const std::lock_guard lock(mutex_);
    return closed_;
  }

  /// Waits for a view newer than `seen`; none if there is none for long, or never will be.
  View next(std::int64_t& seen) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, longest_silence, [&] { return closed_ || number_ > seen; });
    if (closed_ || number_ <= seen) return nullptr;
    seen = number_;
    return view_;
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  View view_;
  std::int64_t number_ = 0;
  bool closed_ = false;
};

/// Counts while it lives.
class Counted {
 public:
  explicit Counted(std::atomic<int>& n) : n_(n) {}
  ~Counted() { --n_; }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;

 private:
  std::atomic<int>& n_;
};

bool write(httplib::DataSink& sink, std::string_view text) {
  return sink.is_writable() && sink.write(text.data(), text.size());
}

/// The library's server on connections of our own: its own ones would read headers without end.
class BoundedServer : public httplib::Server {
  bool process_and_close_socket(socket_t socket) override {
    PageConnection connection(socket, request_limits);
    bool closed = false;
    return process_request(connection, true, closed, nullptr);
  }
};

}  // namespace

bool is_own_host(const std::string& host, int port) {
  const std::string with_port = ":" + std::to_string(port);
  for (const std::string name : {"localhost", "127.0.0.1", "[::1]"}) {
    if (host == name || host == name + with_port) return true;
  }
  return false;
}

class PageServer::Impl {
 public:
  explicit Impl(int port) {
    server_.new_task_queue = [] { return new httplib::ThreadPool(n_threads); };
    // The library's default would let a second server share the port and take half the requests.
    server_.set_socket_options([](int socket) {
      const int yes = 1;
      setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    });
    server_.set_tcp_nodelay(true);
    add_routes();
    bind(port);
    thread_ = std::thread([this] {
      server_.listen_after_bind();
      ended_ = true;
    });
    // Told to stop any earlier, the library would not.
    while (!server_.is_running() && !ended_) std::this_thread::sleep_for(1ms);
  }

  ~Impl() {
    board_.close();
    // The library breaks off what it still sends when it stops.
    const auto end = std::chrono::steady_clock::now() + write_timeout;
    while (n_streams_ > 0 && std::chrono::steady_clock::now() < end) {
      std::this_thread::sleep_for(1ms);
    }
    server_.stop();
    thread_.join();
  }

  int port() const { return port_; }
  int n_streams() const { return n_streams_; }
  void publish(std::string view) {
    board_.put(std::make_shared<const std::string>(std::move(view)));
  }

 private:
  void bind(int port) {
    if (port == 0) {
      port_ = server_.bind_to_any_port(address);
    } else if (server_.bind_to_port(address, port)) {
      port_ = port;
    }
    if (port_ > 0) return;
    throw InputError("port " + std::to_string(port) +
                     " of 127.0.0.1 cannot be served: another program may have it; allowed is a "
                     "free port, and 0 for any free one");
  }

  void add_routes() {
    using httplib::Request, httplib::Response, httplib::Server;
    server_.set_default_headers({{"Content-Security-Policy", content_security_policy()},
                                 {"X-Content-Type-Options", "nosniff"},
                                 {"Referrer-Policy", "no-referrer"},
                                 {"Cache-Control", "no-store"}});
    server_.set_pre_routing_handler([this](const Request& request, Response& response) {
      if (request.method != "GET" && request.method != "HEAD") {
        response.status = 405;
        return Server::HandlerResponse::Handled;
      }
      if (is_own_host(request.get_header_value("Host"), port_)) {
        return Server::HandlerResponse::Unhandled;
      }
      response.status = 403;
      response.set_content("The page is for this machine: http://127.0.0.1\n", "text/plain");
      return Server::HandlerResponse::Handled;
    });
    const auto give = [this](const char* path, std::string_view content, const char* type) {
      server_.Get(path, [content, type](const Request&, Response& response) {
        response.set_content(content.data(), content.size(), type);
      });
    };
    give("/", live_page(), "text/html; charset=utf-8");
    give("/live.js", live_page_script(), "text/javascript; charset=utf-8");
    give("/live.css", live_page_style(), "text/css; charset=utf-8");
    server_.Get("/view", [this](const Request&, Response& response) {
      const View view = board_.newest();
      response.status = view ? 200 : 503;
      response.set_content(view ? *view + "\n" : "", "application/json");
    });
    server_.Get("/events", [this](const Request&, Response& response) { stream(response); });
  }

  void stream(httplib::Response& response) {
    if (++n_streams_ > most_streams || board_.closed()) {
      --n_streams_;
      response.status = 503;
      response.set_header("Retry-After", "5");
      return;
    }
    // Goes with the provider, whatever way the stream ends.
    auto counted = std::make_shared<Counted>(n_streams_);
    auto seen = std::make_shared<std::int64_t>(0);
    response.set_chunked_content_provider(
        "text/event-stream", [this, counted, seen](std::size_t, httplib::DataSink& sink) {
          const View view = board_.next(*seen);
          if (view) return write(sink, "data: " + *view + "\n\n");
          if (!board_.closed()) return write(sink, ": still here\n\n");
          sink.done();
          return true;
        });
  }

  BoundedServer server_;
  Board board_;
  std::atomic<int> n_streams_ = 0;
  std::atomic<bool> ended_ = false;
  int port_ = 0;
  std::thread thread_;
};

PageServer::PageServer(int port) : impl_(std::make_unique<Impl>(port)) {}
PageServer::~PageServer() = default;
int PageServer::port() const { return impl_->port(); }
int PageServer::n_streams() const { return impl_->n_streams(); }
void PageServer::publish(std::string view) { impl_->publish(std::move(view)); }

}  // namespace stillframe::live
