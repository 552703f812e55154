#include "msgs/direct_line.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <utility>

namespace stillframe {

namespace {

/// A measurement or command of thousands of channels; what is larger ends the line.
constexpr std::size_t largest = 1 << 16;

struct Address {
  sockaddr_un socket{};
  socklen_t size = 0;
};

/// In the abstract namespace, which is one of the network namespace, as LCM's multicast is.
Address address_of(std::int64_t plant_instance) {
  Address address;
  address.socket.sun_family = AF_UNIX;
  char* const name = address.socket.sun_path + 1;
  const int length = std::snprintf(name, sizeof address.socket.sun_path - 1, "stillframe-%llx",
                                   static_cast<unsigned long long>(plant_instance));
  address.size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 +
                                        static_cast<std::size_t>(length));
  return address;
}

int new_socket() { return socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0); }

template <class Call>
bool reach(int socket, std::int64_t plant_instance, const Call& call) {
  const Address address = address_of(plant_instance);
  return call(socket, reinterpret_cast<const sockaddr*>(&address.socket), address.size) == 0;
}

}  // namespace

DirectLine::DirectLine(int socket) : socket_(socket), buffer_(largest) {}

DirectLine::DirectLine(DirectLine&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)), buffer_(std::move(other.buffer_)) {}

DirectLine& DirectLine::operator=(DirectLine&& other) noexcept {
  std::swap(socket_, other.socket_);
  std::swap(buffer_, other.buffer_);
  return *this;
}

DirectLine::~DirectLine() {
  if (socket_ >= 0) close(socket_);
}

std::optional<DirectLine> DirectLine::to(std::int64_t plant_instance) {
  const int socket = new_socket();
  if (socket < 0) return std::nullopt;
  DirectLine line(socket);
  if (!reach(socket, plant_instance, ::connect)) return std::nullopt;
  return line;
}

bool DirectLine::send(const char* channel, const void* bytes, std::size_t n_bytes) noexcept {
  iovec parts[] = {{const_cast<char*>(channel), std::strlen(channel) + 1},
                   {const_cast<void*>(bytes), n_bytes}};
  msghdr message{};
  message.msg_iov = parts;
  message.msg_iovlen = 2;
  return sendmsg(socket_, &message, MSG_NOSIGNAL) >= 0;
}

auto DirectLine::take(int timeout_ms) noexcept -> Came {
  pollfd ready{.fd = socket_, .events = POLLIN, .revents = 0};
  if (poll(&ready, 1, timeout_ms) <= 0) return Came::nothing;
  const ssize_t n = recv(socket_, buffer_.data(), buffer_.size(), MSG_TRUNC);
  if (n <= 0 || static_cast<std::size_t>(n) > buffer_.size()) return Came::end;
  const std::string_view all(buffer_.data(), static_cast<std::size_t>(n));
  const std::size_t end = all.find('\0');
  if (end == std::string_view::npos) return Came::end;
  channel_ = all.substr(0, end);
  bytes_ = all.substr(end + 1);
  return Came::message;
}

LineOffer::LineOffer(std::int64_t plant_instance) : socket_(new_socket()) {
  if (socket_ < 0) return;
  if (reach(socket_, plant_instance, ::bind) && listen(socket_, 4) == 0) return;
  close(std::exchange(socket_, -1));
}

LineOffer::~LineOffer() {
  if (socket_ >= 0) close(socket_);
}

std::optional<DirectLine> LineOffer::accepted() {
  if (socket_ < 0) return std::nullopt;
  while (true) {
    const int socket = accept4(socket_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket < 0) return std::nullopt;
    DirectLine line(socket);
    // Who hears LCM knows the name; a line is for processes of one user.
    ucred peer{};
    socklen_t size = sizeof peer;
    if (getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &peer, &size) == 0 && peer.uid == geteuid()) {
      return line;
    }
  }
}

}  // namespace stillframe
