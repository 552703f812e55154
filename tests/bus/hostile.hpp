#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <string_view>

// Datagrams that no LCM would send.
namespace stillframe::test {

/// The lowest n bytes of a number, highest first.
std::string big_endian(std::uint64_t value, int n);

/// A whole message, as in one datagram, and one fragment.
std::string whole_datagram(std::string_view channel, std::string_view payload);
struct Fragment {
  std::uint32_t message = 0, size = 0, offset = 0;
  std::uint16_t number = 0, n_fragments = 0;
};
std::string fragment_datagram(const Fragment& header, std::string_view rest);

/// One whose every field is drawn from those around the bounds of it, cut at any place: most of
/// them would kill a process with an unguarded liblcm 1.3.1 sooner or later.
std::string hostile_datagram(std::mt19937_64& random);

/// A payload of a type whose list claims n entries and has none. count_at: where the count stands.
template <class Message>
std::string huge_claim(const Message& message, std::size_t count_at, std::uint32_t n) {
  std::string bytes(static_cast<std::size_t>(message.getEncodedSize()), '\0');
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes.replace(count_at, 4, big_endian(n, 4));
}

/// A socket that sends to the default group and port of LCM, or one of this machine's own.
class HostileSender {
 public:
  explicit HostileSender(int port = 7667, const char* group = "239.255.76.67");
  ~HostileSender();
  HostileSender(const HostileSender&) = delete;
  HostileSender& operator=(const HostileSender&) = delete;

  void send(std::string_view datagram) const;
  /// n hostile ones.
  void send_hostile(int n);

 private:
  int socket_, port_;
  const char* group_;
  std::mt19937_64 random_{20};
};

}  // namespace stillframe::test
