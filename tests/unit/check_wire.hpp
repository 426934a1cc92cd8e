#pragma once

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <type_traits>
#include <vector>

#include "catch.hpp"
#include "wire_messages.hpp"

namespace crsm {

template <class Message>
bool IsDecoded(const std::vector<std::uint8_t>& bytes) {
  return Decode<Message>(bytes).has_value();
}

/// A message that is accepted, and what else its fields may hold. A field is a part of `message`; each of the values is
/// tried alone.
template <class Message>
class Fields {
 public:
  explicit Fields(const Message& accepted) : message(accepted) { CHECK(IsDecoded<Message>(Encode(message))); }
  Fields(const Fields&) = delete;
  Fields& operator=(const Fields&) = delete;

  template <class Value>
  void Accept(Value& field, std::initializer_list<std::type_identity_t<Value>> values) {
    Try(field, values, true);
  }
  template <class Value>
  void Refuse(Value& field, std::initializer_list<std::type_identity_t<Value>> values) {
    Try(field, values, false);
  }
  void AreFlags(std::initializer_list<std::int8_t*> fields) {
    for (std::int8_t* field : fields) {
      Accept(*field, {0, 1});
      Refuse(*field, {-1, 2});
    }
  }
  /// Whether each of its three numbers has to be one that there can be.
  void IsPose(pose2_t& pose) {
    for (double* position_m : {&pose.x_m, &pose.y_m}) Refuse(*position_m, {NAN, 1.1e6, -1.1e6});
    Refuse(pose.yaw_rad, {NAN, 6.4, -6.4});
  }
  /// Whether the message is still accepted after `change`.
  template <class Change>
  bool After(Change change) const {
    Message changed = message;
    change(changed);
    return IsDecoded<Message>(Encode(changed));
  }

  Message message;

 private:
  template <class Value>
  void Try(Value& field, std::initializer_list<Value> values, bool accepted) {
    const Value before = field;
    for (const Value& value : values) {
      INFO("value " << &value - values.begin());
      field = value;
      CHECK(IsDecoded<Message>(Encode(message)) == accepted);
    }
    field = before;
  }
};

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
