#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace stillframe {

/// Two processes in one network namespace hand each other whole messages of LCM channels, beside
/// LCM, on which both go on to publish: a Unix socket without a name in any file system. The other
/// end is woken by the message itself, where liblcm's receiving thread and its pipe stand between.
/// Source: docs/decisions/0037-direct-line.md.
class DirectLine {
 public:
  /// To the offer of a plant, nothing if there is none here. Set-up.
  static std::optional<DirectLine> to(std::int64_t plant_instance);

  DirectLine(DirectLine&& other) noexcept;
  DirectLine& operator=(DirectLine&& other) noexcept;
  ~DirectLine();

  /// False where the other end has gone, or has not read for long. Hot: noexcept, no allocation.
  bool send(const char* channel, const void* bytes, std::size_t n_bytes) noexcept;

  enum class Came { nothing, message, end };
  /// Waits up to timeout_ms; a signal ends the wait early. Hot, likewise.
  Came take(int timeout_ms) noexcept;
  /// Of the message that came, until the next take.
  std::string_view channel() const noexcept { return channel_; }
  std::string_view bytes() const noexcept { return bytes_; }

  /// For poll, beside others.
  int descriptor() const noexcept { return socket_; }

 private:
  friend class LineOffer;
  explicit DirectLine(int socket);

  int socket_;
  std::vector<char> buffer_;
  std::string_view channel_, bytes_;
};

/// A plant's end, until somebody has come.
class LineOffer {
 public:
  /// Where the system refuses, nobody will come. Set-up.
  explicit LineOffer(std::int64_t plant_instance);
  LineOffer(const LineOffer&) = delete;
  LineOffer& operator=(const LineOffer&) = delete;
  ~LineOffer();

  /// The line to the first process of this user that came, without waiting. Set-up.
  std::optional<DirectLine> accepted();

 private:
  int socket_;
};

}  // namespace stillframe
