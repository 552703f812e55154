#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

// What goes over a device, in words of 32 bits of the machine's byte order: a mark, the number of
// the sample, whole numbers as converters count, and the sum of all words before.
//   from the converters:  mark_samples,  number, sigma, applied, floor, frame, sum
//   to the converters:    mark_commands, number, 1 if the amplifiers are enabled else 0, force, sum
// Numbers of samples wrap at 2^32. In a period without a command there is no frame: amplifiers that
// hear none let go.
namespace stillframe::controller {

inline constexpr std::uint32_t mark_samples = 0x314d4653, mark_commands = 0x31434653;

inline std::uint32_t sum_of(std::span<const std::uint32_t> words) noexcept {
  std::uint32_t sum = 0;
  for (const std::uint32_t word : words) sum = sum * 31 + word;
  return sum;
}

/// Finds frames of one kind and length in a stream that may begin anywhere and lose bytes.
/// Construction is set-up; the rest is hot.
class FrameSearch {
 public:
  /// n_words: with mark and sum.
  FrameSearch(std::uint32_t mark, std::size_t n_words)
      : mark_(mark), n_bytes_(4 * n_words), words_(n_words), bytes_(16 * n_bytes_) {}

  /// Where to read on to, never empty; filled: so many bytes came.
  std::span<std::uint8_t> room() noexcept {
    std::memmove(bytes_.data(), bytes_.data() + from_, to_ - from_);
    to_ -= from_;
    from_ = 0;
    return {bytes_.data() + to_, bytes_.size() - to_};
  }
  void filled(std::size_t n) noexcept { to_ += n; }

  /// The next whole frame, valid until the next call; empty if there is none yet.
  std::span<const std::uint32_t> next() noexcept {
    while (to_ - from_ >= n_bytes_) {
      std::memcpy(words_.data(), bytes_.data() + from_, n_bytes_);
      if (words_.front() == mark_ &&
          sum_of(std::span(words_).first(words_.size() - 1)) == words_.back()) {
        from_ += n_bytes_;
        return words_;
      }
      ++from_;
      ++n_skipped_;
    }
    return {};
  }
  std::int64_t n_skipped() const noexcept { return n_skipped_; }  ///< bytes of no frame

 private:
  std::uint32_t mark_;
  std::size_t n_bytes_, from_ = 0, to_ = 0;
  std::vector<std::uint32_t> words_;
  std::vector<std::uint8_t> bytes_;
  std::atomic<std::int64_t> n_skipped_{0};
};

}  // namespace stillframe::controller
