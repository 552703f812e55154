#pragma once

#include <httplib.h>

#include <chrono>
#include <string>

namespace stillframe::live {

/// What a browser may ask for, and how long it may take.
struct RequestLimits {
  std::size_t bytes = 0;                      ///< of the whole request
  std::chrono::milliseconds read{}, write{};  ///< for all of it, and for each piece of the answer
};

/// A connection that gives its request up where that is too long or takes too long, and closes its
/// socket when it goes. One thread. Set-up.
class PageConnection : public httplib::Stream {
 public:
  PageConnection(int socket, const RequestLimits& limits);
  ~PageConnection() override;
  PageConnection(const PageConnection&) = delete;
  PageConnection& operator=(const PageConnection&) = delete;

  bool is_readable() const override;
  bool is_writable() const override;
  ssize_t read(char* to, size_t size) override;
  ssize_t write(const char* from, size_t size) override;
  void get_remote_ip_and_port(std::string& ip, int& port) const override;
  void get_local_ip_and_port(std::string& ip, int& port) const override;
  socket_t socket() const override { return socket_; }

 private:
  std::chrono::milliseconds time_left() const;

  int socket_;
  std::size_t bytes_left_;
  std::chrono::steady_clock::time_point read_until_;
  std::chrono::milliseconds write_;
};

}  // namespace stillframe::live
