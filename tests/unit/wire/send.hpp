#pragma once

#include "catch.hpp"
#include "services/wire/wire.hpp"
#include "wire_messages.hpp"

namespace crsm {

/// Over the wire: what the other side gets.
template <class Message>
Message Send(const Message& message) {
  const auto received = Decode<Message>(Encode(message));
  REQUIRE(received);
  return *received;
}

}  // namespace crsm
