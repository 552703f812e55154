#include "tests/bus/hostile.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <stdexcept>
#include <vector>

namespace stillframe::test {

namespace {

template <class T>
T any_of(std::mt19937_64& random, const std::vector<T>& values) {
  return values[random() % values.size()];
}

std::uint32_t some_size(std::mt19937_64& random) {
  const std::uint32_t around = any_of<std::uint32_t>(
      random, {0, 0, 20, 64, 1u << 16, 1u << 24, 1u << 28, 1u << 31, ~0u, ~0u});
  return around + static_cast<std::uint32_t>(random() % 41) - 20;
}

std::string some_channel(std::mt19937_64& random) {
  std::string channel =
      any_of<std::string>(random, {"SF_MEASUREMENT", "SF_COMMAND", "SF_RUN_INFO", "SF_RUN_STATE",
                                   "SF_STATUS", "SF_LOOP", "SF_REQUEST", "SF_TIMING",
                                   "SF_CHECKPOINT", "SF_OTHER", "", std::string(300, 'x')});
  if (random() % 4 == 0 && !channel.empty()) channel[random() % channel.size()] ^= 1;
  if (random() % 4 != 0) channel += '\0';
  return channel;
}

}  // namespace

std::string big_endian(std::uint64_t value, int n) {
  std::string bytes;
  for (int i = n - 1; i >= 0; --i) bytes += static_cast<char>(value >> (8 * i));
  return bytes;
}

std::string whole_datagram(std::string_view channel, std::string_view payload) {
  return "LC02" + big_endian(0, 4) + std::string(channel) + '\0' + std::string(payload);
}

std::string fragment_datagram(const Fragment& header, std::string_view rest) {
  return "LC03" + big_endian(header.message, 4) + big_endian(header.size, 4) +
         big_endian(header.offset, 4) + big_endian(header.number, 2) +
         big_endian(header.n_fragments, 2) + std::string(rest);
}

std::string hostile_datagram(std::mt19937_64& random) {
  const std::string rest(random() % (random() % 8 == 0 ? 60'000 : 200), '\x7f');
  std::string datagram;
  if (random() % 4 == 0) {
    datagram = "LC02" + big_endian(random(), 4) + some_channel(random) + rest;
  } else {
    const Fragment header{.message = static_cast<std::uint32_t>(random() % 3),
                          .size = some_size(random),
                          .offset = random() % 2 == 0 ? 0 : some_size(random),
                          .number = any_of<std::uint16_t>(random, {0, 0, 1, 2, 0xffff}),
                          .n_fragments = any_of<std::uint16_t>(random, {0, 1, 1, 2, 3, 0xffff})};
    datagram = fragment_datagram(header, (random() % 4 == 0 ? "" : some_channel(random)) + rest);
  }
  if (random() % 16 == 0) datagram[random() % 4] ^= 1;
  if (random() % 4 == 0) datagram.resize(random() % datagram.size());
  return datagram;
}

HostileSender::HostileSender(int port, const char* group)
    : socket_(socket(AF_INET, SOCK_DGRAM, 0)), port_(port), group_(group) {
  const unsigned char ttl = 0;
  if (socket_ < 0 || setsockopt(socket_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl) != 0) {
    throw std::runtime_error("no socket");
  }
}

HostileSender::~HostileSender() { close(socket_); }

void HostileSender::send(std::string_view datagram) const {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(port_));
  inet_aton(group_, &to.sin_addr);
  sendto(socket_, datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&to),
         sizeof to);
}

void HostileSender::send_hostile(int n) {
  for (int i = 0; i < n; ++i) send(hostile_datagram(random_));
}

}  // namespace stillframe::test
