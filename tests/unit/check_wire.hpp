#pragma once

#include <cstdint>
#include <vector>

#include "catch.hpp"
#include "wire_messages.hpp"

namespace crsm {

template <class Message>
bool IsDecoded(const std::vector<std::uint8_t>& bytes) {
  return Decode<Message>(bytes).has_value();
}

/// Whether the message is still accepted after `change`.
template <class Message, class Change>
bool IsDecoded(Message message, Change change) {
  change(message);
  return IsDecoded<Message>(Encode(message));
}

/// What holds for every type, whatever is in it.
template <class Message>
void CheckType(const Message& message) {
  using Bytes = std::vector<std::uint8_t>;
  CAPTURE(Message::getTypeName());
  const Bytes bytes = Encode(message);
  const auto decoded = Decode<Message>(bytes);
  REQUIRE(decoded);
  CHECK(Encode(*decoded) == bytes);

  for (std::size_t size = 0; size < bytes.size(); ++size) {  // a copy, so that reading beyond it is an error
    CAPTURE(size);
    CHECK_FALSE(IsDecoded<Message>(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size))));
  }
  Bytes longer = bytes;
  longer.push_back(0);
  CHECK_FALSE(IsDecoded<Message>(longer));
  for (std::size_t i = 0; i < 8; ++i) {
    Bytes other_type = bytes;
    other_type[i] ^= 1;
    CHECK_FALSE(IsDecoded<Message>(other_type));
  }
  // Any byte may be anything: refused or taken, but read within its bounds.
  for (std::size_t i = 8; i < bytes.size(); ++i) {
    for (const int byte : {0x00, 0x01, 0x7f, 0x80, 0xff}) {
      Bytes hostile = bytes;
      hostile[i] = static_cast<std::uint8_t>(byte);
      const auto taken = Decode<Message>(hostile);
      if (taken) CHECK(taken->getEncodedSize() == static_cast<int>(hostile.size()));
    }
  }
}

}  // namespace crsm
