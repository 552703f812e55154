#pragma once

#include <memory>
#include <string>

namespace stillframe::live {

/// Serves the live page and the newest view to browsers on this machine. Every browser has a thread
/// that gives it the newest view and skips those it was too slow for; nobody waits for any of them.
/// Nothing can be changed through it. Set-up.
///   /         the page
///   /events   the views as server-sent events, as they are published
///   /view     the newest one, as JSON
class PageServer {
 public:
  /// So many streams of events at once; one more is told to come again (503).
  static constexpr int most_streams = 64;

  /// Listens on 127.0.0.1; port 0 is any free one. Errors: InputError if the port is taken.
  explicit PageServer(int port);
  /// Ends all streams; waits two seconds at most for browsers that do not read.
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  int port() const;
  /// Browsers that get views now.
  int n_streams() const;
  /// Gives a view to all of them: JSON in one line.
  void publish(std::string view);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// Whether a Host header names this machine itself: localhost, 127.0.0.1 or [::1], with the port or
/// without. A page from elsewhere whose name was made to lead here has another one.
bool is_own_host(const std::string& host, int port);

}  // namespace stillframe::live
