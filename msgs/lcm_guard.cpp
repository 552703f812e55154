#include "msgs/lcm_guard.hpp"

#include <dlfcn.h>
#include <linux/filter.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <initializer_list>
#include <string_view>
#include <vector>

#include "msgs/channels.hpp"

namespace stillframe {

namespace {

// Where things stand in a datagram, which for a filter begins with the header of UDP.
constexpr std::uint32_t udp = 8, magic = udp;
constexpr std::uint32_t short_channel = udp + 8;
constexpr std::uint32_t size = udp + 8, offset = udp + 12, number = udp + 16,
                        n_fragments = udp + 18;
constexpr std::uint32_t long_channel = udp + 20;

constexpr std::uint32_t magic_short = 0x4c433032, magic_long = 0x4c433033;  // LC02, LC03
// More than any fragment carries, so that so many of them hold the message.
constexpr std::uint32_t most_a_fragment = 65535;

constexpr std::uint32_t drop = 0, keep = ~0u;

constexpr const char* names[] = {
    channels::measurement, channels::command,    channels::run_info, channels::run_state,
    channels::timing,      channels::request,    channels::status,   channels::loop,
    channels::checkpoint,  channels::excitation, channels::clock,    channels::logger_check,
    "LCM_SELF_TEST",  // that liblcm sends itself before it goes on
};

class Program {
 public:
  std::vector<sock_filter> code;

  void add(int operation, std::uint32_t k, std::size_t if_true = 0, std::size_t if_false = 0) {
    code.push_back({static_cast<std::uint16_t>(operation), static_cast<std::uint8_t>(if_true),
                    static_cast<std::uint8_t>(if_false), k});
  }
  void answer(std::uint32_t what) { add(BPF_RET | BPF_K, what); }
  /// Drops unless (unless: if) the comparison holds.
  void require(int comparison, std::uint32_t k) {
    add(BPF_JMP | comparison, k, 1, 0);
    answer(drop);
  }
  void require_not(int comparison, std::uint32_t k) {
    add(BPF_JMP | comparison, k, 0, 1);
    answer(drop);
  }
  void load(int width, std::uint32_t at) { add(BPF_LD | width | BPF_ABS, at); }
  void load_x(std::uint32_t k) { add(BPF_LDX | BPF_IMM, k); }

  /// Keeps what has this name, and its end, at the place in X. A load beyond the end of the
  /// datagram drops it.
  void keep_channel(std::string_view name) {
    std::string_view rest(name.data(), name.size() + 1);
    std::vector<std::size_t> misses;
    for (std::uint32_t at = 0; !rest.empty();) {
      const std::size_t n = rest.size() >= 4 ? 4 : rest.size() >= 2 ? 2 : 1;
      std::uint32_t value = 0;
      for (const char c : rest.substr(0, n)) value = value << 8 | static_cast<unsigned char>(c);
      add(BPF_LD | (n == 4 ? BPF_W : n == 2 ? BPF_H : BPF_B) | BPF_IND, at);
      misses.push_back(code.size());
      add(BPF_JMP | BPF_JEQ | BPF_K, value);
      rest.remove_prefix(n);
      at += static_cast<std::uint32_t>(n);
    }
    answer(keep);
    for (const std::size_t miss : misses) {
      code[miss].jf = static_cast<std::uint8_t>(code.size() - miss - 1);
    }
  }
};

std::vector<sock_filter> make_guard() {
  Program p;
  // A whole message: only its channel has to be known.
  p.load_x(short_channel);
  p.load(BPF_W, magic);
  p.add(BPF_JMP | BPF_JEQ | BPF_K, magic_short, 0, 0);
  const std::size_t to_channel = p.code.size() - 1;
  p.require(BPF_JEQ | BPF_K, magic_long);
  // A fragment: offset <= size <= the largest, 0 <= number < n, and n of them hold the size. Then
  // no sum that liblcm makes of them overflows, and its own check does what it says.
  p.load(BPF_W, size);
  p.require_not(BPF_JGT | BPF_K, largest_message);
  p.add(BPF_ST, 0);
  p.add(BPF_LDX | BPF_MEM, 0);
  p.load(BPF_W, offset);
  p.require_not(BPF_JGT | BPF_X, 0);
  p.load(BPF_H, n_fragments);
  p.add(BPF_MISC | BPF_TAX, 0);
  p.add(BPF_ALU | BPF_MUL | BPF_K, most_a_fragment);
  p.add(BPF_ST, 1);
  p.load(BPF_H, number);
  p.require_not(BPF_JGE | BPF_X, 0);
  p.add(BPF_LDX | BPF_MEM, 0);
  p.add(BPF_LD | BPF_MEM, 1);
  p.require(BPF_JGE | BPF_X, 0);
  // The first has the channel in front, and begins at the beginning.
  p.load(BPF_H, number);
  p.add(BPF_JMP | BPF_JEQ | BPF_K, 0, 1, 0);
  p.answer(keep);
  p.load(BPF_W, offset);
  p.require(BPF_JEQ | BPF_K, 0);
  p.load_x(long_channel);
  p.code[to_channel].jt = static_cast<std::uint8_t>(p.code.size() - to_channel - 1);
  for (const char* name : names) p.keep_channel(name);
  p.answer(drop);
  return p.code;
}

}  // namespace

std::span<const sock_filter> lcm_guard() {
  static const std::vector<sock_filter> guard = make_guard();
  return guard;
}

bool attach_lcm_guard(int socket) noexcept {
  const auto guard = lcm_guard();
  const sock_fprog program{static_cast<unsigned short>(guard.size()),
                           const_cast<sock_filter*>(guard.data())};
  return setsockopt(socket, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program) == 0;
}

}  // namespace stillframe

/// bind() for all of this process, liblcm among it: a UDP socket has the guard before the first
/// datagram can be in it.
extern "C" __attribute__((visibility("default"))) int bind(int fd, const sockaddr* address,
                                                           socklen_t length) noexcept {
  int type = 0;
  socklen_t size_of_type = sizeof type;
  const bool known = getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, &size_of_type) == 0;
  const bool internet = address != nullptr && address->sa_family == AF_INET;
  if (known && type == SOCK_DGRAM && internet && !stillframe::attach_lcm_guard(fd)) return -1;
  return static_cast<int>(syscall(SYS_bind, fd, address, length));
}

namespace stillframe {

bool lcm_is_guarded() noexcept {
  return dlsym(RTLD_DEFAULT, "bind") == reinterpret_cast<void*>(&::bind);
}

}  // namespace stillframe
