#include "tests/live/http_client.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>

namespace stillframe::live {

Connection::Connection(int port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return;
  close(socket_);
  socket_ = -1;
}

Connection::~Connection() {
  if (socket_ >= 0) close(socket_);
}

void Connection::send(const std::string& text) const {
  ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL);
}

bool Connection::hears_within(int ms) const {
  pollfd ready{.fd = socket_, .events = POLLIN, .revents = 0};
  return poll(&ready, 1, ms) > 0;
}

std::string Connection::read_until(const std::string& part) {
  std::array<char, 65536> buffer;
  while (read_.find(part) == std::string::npos) {
    const ssize_t n = recv(socket_, buffer.data(), buffer.size(), 0);
    if (n <= 0) break;
    read_.append(buffer.data(), static_cast<std::size_t>(n));
  }
  return read_;
}

std::string get(int port, const std::string& path, const std::string& headers) {
  Connection connection(port);
  if (!connection.open()) return "";
  connection.send("GET " + path + " HTTP/1.1\r\n" +
                  (headers.empty() ? "Host: 127.0.0.1\r\n" : headers) +
                  "Connection: close\r\n\r\n");
  return connection.read_all();
}

}  // namespace stillframe::live
