#include "report/live/page_connection.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>

namespace stillframe::live {

using std::chrono::milliseconds, std::chrono::steady_clock;

namespace {

bool is_ready(int socket, short event, milliseconds wait) {
  pollfd ready{.fd = socket, .events = event, .revents = 0};
  return poll(&ready, 1, static_cast<int>(wait.count())) > 0 && (ready.revents & event) != 0;
}

}  // namespace

PageConnection::PageConnection(int socket, const RequestLimits& limits)
    : socket_(socket),
      bytes_left_(limits.bytes),
      read_until_(steady_clock::now() + limits.read),
      write_(limits.write) {}

PageConnection::~PageConnection() {
  shutdown(socket_, SHUT_RDWR);
  close(socket_);
}

milliseconds PageConnection::time_left() const {
  const auto left = std::chrono::ceil<milliseconds>(read_until_ - steady_clock::now());
  return std::max(left, milliseconds(0));
}

bool PageConnection::is_readable() const {
  return bytes_left_ > 0 && is_ready(socket_, POLLIN, time_left());
}

bool PageConnection::is_writable() const { return is_ready(socket_, POLLOUT, write_); }

ssize_t PageConnection::read(char* to, size_t size) {
  if (!is_readable()) return -1;
  const ssize_t n = recv(socket_, to, std::min(size, bytes_left_), MSG_DONTWAIT);
  if (n > 0) bytes_left_ -= static_cast<std::size_t>(n);
  return n;
}

ssize_t PageConnection::write(const char* from, size_t size) {
  if (!is_writable()) return -1;
  return send(socket_, from, size, MSG_NOSIGNAL | MSG_DONTWAIT);
}

// Nobody asks: the page is for this machine.
void PageConnection::get_remote_ip_and_port(std::string& ip, int& port) const {
  ip.clear();
  port = 0;
}

void PageConnection::get_local_ip_and_port(std::string& ip, int& port) const {
  ip.clear();
  port = 0;
}

}  // namespace stillframe::live
