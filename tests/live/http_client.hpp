#pragma once

#include <string>

namespace stillframe::live {

/// A connection to a port of this machine, as bare as a test needs it.
class Connection {
 public:
  explicit Connection(int port);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  bool open() const { return socket_ >= 0; }
  void send(const std::string& text) const;
  /// True once there is something to read or the other side has closed, within so many ms.
  bool hears_within(int ms) const;
  /// Reads until `part` has come or the other side has closed; all that came.
  std::string read_until(const std::string& part);
  std::string read_all() { return read_until("\x01 never"); }

 private:
  int socket_ = -1;
  std::string read_;
};

/// The answer to GET path with these headers, Host: 127.0.0.1 if empty.
std::string get(int port, const std::string& path, const std::string& headers = "");

}  // namespace stillframe::live
