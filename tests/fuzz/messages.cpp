#include <string>
#include <utility>
#include <vector>

#include "msgs/message_fit.hpp"
#include "tests/fuzz/message_types.hpp"
#include "tests/fuzz/targets.hpp"

namespace stillframe::fuzz {

namespace {

/// A message that fits its bytes is decoded from exactly these; texts are written up to a zero, so
/// that with zeros inside them fewer come back. The fingerprint is put before bytes that have none:
/// most inputs would end there.
template <typename Message>
void take(std::string_view body) {
  std::vector<char> bytes;  // of its own, so that the sanitizer sees where they end
  const auto hash = static_cast<std::uint64_t>(Message::getHash());
  for (int shift = 56; shift >= 0; shift -= 8) bytes.push_back(static_cast<char>(hash >> shift));
  bytes.insert(bytes.end(), body.begin(), body.end());
  const std::string_view payload(bytes.data(), bytes.size());
  Message message;
  const bool decoded = decode(payload, message);
  require(decoded == (fit<Message>(payload) == Fit::whole), "what fits is decoded whole");
  require(!decoded || message.getEncodedSize() <= static_cast<int>(bytes.size()),
          "no more comes out than went in");
}

template <std::size_t... i>
void decode_as(std::size_t type, std::string_view body, std::index_sequence<i...>) {
  ((type == i ? take<std::tuple_element_t<i, MessageTypes>>(body) : void()), ...);
}

}  // namespace

void messages(std::string_view bytes) {
  if (bytes.empty()) return;
  constexpr std::size_t n_types = std::tuple_size_v<MessageTypes>;
  decode_as(static_cast<unsigned char>(bytes.front()) % n_types, bytes.substr(1),
            std::make_index_sequence<n_types>());
}

}  // namespace stillframe::fuzz
