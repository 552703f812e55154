// The guard before liblcm's socket against a plain reading of the wire format.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "msgs/big_endian.hpp"
#include "msgs/lcm_guard.hpp"
#include "tests/bus/hostile.hpp"

namespace stillframe {
namespace {

using test::big_endian, test::Fragment, test::fragment_datagram, test::whole_datagram;

/// A UDP socket of 127.0.0.1 that is bound by this program's own bind().
class GuardedSocket {
 public:
  GuardedSocket() : socket_(socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size), 0);
    port_ = ntohs(address.sin_port);
  }
  ~GuardedSocket() { close(socket_); }
  int port() const { return port_; }
  std::string receive() const {
    std::array<char, 65536> bytes{};
    const ssize_t n = recv(socket_, bytes.data(), bytes.size(), 0);
    return {bytes.data(), static_cast<std::size_t>(std::max<ssize_t>(n, 0))};
  }

 private:
  int socket_, port_ = 0;
};

/// Whether liblcm 1.3.1 can take a datagram: its channel is one of ours and ends, or it is a later
/// fragment; and no length of a fragment contradicts another.
bool is_harmless(const std::string& datagram) {
  const auto number = [&](std::size_t at, int n) { return read_big_endian(&datagram[at], n); };
  const auto has_channel = [&](std::size_t at) {
    const std::size_t end = datagram.find('\0', at);
    if (end == std::string::npos) return false;
    const std::string name = datagram.substr(at, end - at);
    for (const char* known :
         {"SF_MEASUREMENT", "SF_COMMAND", "SF_RUN_INFO", "SF_RUN_STATE", "SF_TIMING", "SF_REQUEST",
          "SF_STATUS", "SF_LOOP", "SF_CHECKPOINT", "SF_LOGGER_CHECK", "LCM_SELF_TEST"}) {
      if (name == known) return true;
    }
    return false;
  };
  if (datagram.starts_with("LC02")) return datagram.size() > 8 && has_channel(8);
  if (!datagram.starts_with("LC03") || datagram.size() < 20) return false;
  const std::uint64_t size = number(8, 4), offset = number(12, 4), i = number(16, 2),
                      n = number(18, 2);
  if (size > largest_message || offset > size || i >= n || size > n * 65535) return false;
  return i > 0 || (offset == 0 && datagram.size() > 20 && has_channel(20));
}

class LcmGuard : public testing::Test {
 protected:
  /// Loopback keeps the order, so what comes before the mark is what was sent before it.
  bool passes(const std::string& datagram) {
    sender_.send(datagram);
    sender_.send(mark_);
    const std::string first = socket_.receive();
    if (first == mark_) return false;
    EXPECT_EQ(first, datagram);
    EXPECT_EQ(socket_.receive(), mark_);
    return true;
  }

 private:
  GuardedSocket socket_;
  test::HostileSender sender_{socket_.port(), "127.0.0.1"};
  const std::string mark_ = whole_datagram("SF_LOGGER_CHECK", "mark");
};

TEST_F(LcmGuard, IsAtEverySocketThatThisProcessBinds) {
  EXPECT_TRUE(lcm_is_guarded());
  EXPECT_TRUE(passes(whole_datagram("SF_COMMAND", "x")));
  EXPECT_FALSE(passes(whole_datagram("SF_COMMANDO", "x")));
}

TEST_F(LcmGuard, LetsThroughWhatLiblcmCanTakeAndNothingElse) {
  std::mt19937_64 random(15);
  int n_passed = 0, n_dropped = 0;
  for (int trial = 0; trial < 40'000; ++trial) {
    const std::string datagram = test::hostile_datagram(random);
    const bool expected = is_harmless(datagram);
    ASSERT_EQ(passes(datagram), expected) << trial;
    ++(expected ? n_passed : n_dropped);
  }
  EXPECT_GT(n_passed, 2000);  // both answers are asked for often
  EXPECT_GT(n_dropped, 2000);
}

TEST_F(LcmGuard, DropsTheFragmentsThatAreKnownToKill) {
  std::string channel("SF_MEASUREMENT");
  channel += '\0';
  const std::string payload(64, 'x');
  const Fragment sound{.message = 1, .size = 64, .offset = 0, .number = 0, .n_fragments = 1};
  EXPECT_TRUE(passes(fragment_datagram(sound, channel + payload)));
  Fragment wraps = sound;  // offset + length is less than the size, modulo 2^32
  wraps.offset = 0xffffffff;
  wraps.number = 1;
  wraps.n_fragments = 2;
  EXPECT_FALSE(passes(fragment_datagram(wraps, payload)));
  // Shorter than its header: the length of its data is taken for almost 2^32.
  for (std::size_t size = 8; size < 20; ++size) {
    EXPECT_FALSE(passes(fragment_datagram(sound, "").substr(0, size))) << size;
  }
  // A channel that does not end within the datagram, but in what an earlier one left behind it.
  EXPECT_FALSE(passes(fragment_datagram(sound, "SF_MEASUREMENT")));
  EXPECT_FALSE(passes("LC02" + big_endian(1, 4) + "SF_COMMAND"));
}

}  // namespace
}  // namespace stillframe
