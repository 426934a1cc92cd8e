#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace crsm {

/// FieldsOf<Message>::Visit(visit) calls visit with each member of a message, in the order of the wire: &T::utime,
/// &T::num, Array(&T::values, &T::num, 99). The build makes one for each type from its .lcm file:
/// <wire_fields/PACKAGE/TYPE.hpp>.
template <class Message>
struct FieldsOf;

/// Whether the values of a decoded message are in range: finite, possible, consistent. Each type has one, too.
template <class Message>
bool ValuesInRange(const Message& message);

/// A member whose length stands in an earlier member.
template <class Message, class Element, class Count>
struct ArrayField {
  std::vector<Element> Message::*elements;
  Count Message::*count;  ///< may be that of several arrays
  std::size_t most;       ///< elements that are allowed
};

template <class Message, class Element, class Count>
constexpr ArrayField<Message, Element, Count> Array(std::vector<Element> Message::*elements, Count Message::*count,
                                                    std::size_t most) {
  return {elements, count, most};
}

/// The most elements that the arrays of a count may have, as MostOf(&T::num).
template <class Message, class Count>
constexpr std::size_t MostOf(Count Message::*count) {
  std::size_t most = 0;
  FieldsOf<Message>::Visit([&](const auto& field) {
    if constexpr (requires { field.count == count; }) {
      if (field.count == count) most = field.most;
    }
  });
  return most;
}

/// Walks over an encoded message without decoding it. Decoders that lcm-gen makes trust array counts: a hostile count
/// crashes or exhausts a process that decodes blindly, so every count is held against the bytes that are there first.
class WireReader {
 public:
  /// bytes: the whole message, its fingerprint included.
  explicit WireReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) { Skip(8); }

  /// Walks over the fields of a message.
  template <class Message>
  void WalkMessage() {
    Message message{};  // of which only the integers are filled in: some are counts
    FieldsOf<Message>::Visit([&](const auto& field) { WalkField(message, field); });
  }

  /// Whether all of the message was walked over and nothing was wrong.
  bool Whole() const { return ok_ && bytes_.empty(); }

 private:
  template <class Message, class Value>
  void WalkField(Message& message, Value Message::*member) {
    WalkValue(message.*member);
  }

  template <class Message, class Element, class Count>
  void WalkField(Message& message, const ArrayField<Message, Element, Count>& array) {
    const Count count = message.*array.count;
    ok_ = ok_ && count >= 0 && std::cmp_less_equal(count, array.most);
    if (!ok_) return;
    if constexpr (std::is_arithmetic_v<Element>) return Skip(static_cast<std::size_t>(count) * sizeof(Element));
    Element element{};
    for (Count i = 0; i < count && ok_; ++i) WalkValue(element);
  }

  template <class Value>
  void WalkValue(Value& value) {
    if constexpr (std::is_integral_v<Value>) {
      value = ReadInteger<Value>();
    } else if constexpr (std::is_arithmetic_v<std::remove_all_extents_t<Value>>) {  // or an array of fixed size
      Skip(sizeof(Value));
    } else if constexpr (std::is_same_v<Value, std::string>) {
      SkipString();
    } else {
      WalkMessage<Value>();
    }
  }

  void SkipString() {
    constexpr std::int32_t kLongest = 1024;
    const auto size = ReadInteger<std::int32_t>();  // with the NUL at the end
    ok_ = ok_ && size >= 1 && size <= kLongest;
    Skip(static_cast<std::size_t>(size));
  }

  /// 0 if it is not there.
  template <class Integer>
  Integer ReadInteger() {
    const auto bytes = bytes_;
    Skip(sizeof(Integer));
    std::uint64_t value = 0;
    for (std::size_t i = 0; ok_ && i < sizeof(Integer); ++i) value = value << 8 | bytes[i];
    return static_cast<Integer>(value);
  }

  void Skip(std::size_t size) {
    ok_ = ok_ && size <= bytes_.size();
    if (ok_) bytes_ = bytes_.subspan(size);
  }

  std::span<const std::uint8_t> bytes_;  ///< still to be walked over
  bool ok_ = true;
};

/// Whether the bytes of a message are those of its fields, no more and no less, with every count in its limits.
template <class Message>
bool CountsFit(std::span<const std::uint8_t> bytes) {
  WireReader reader(bytes);
  reader.WalkMessage<Message>();
  return reader.Whole();
}

/// What type a message says it is: its first eight bytes; 0 if it is shorter.
inline std::uint64_t Fingerprint(std::span<const std::uint8_t> bytes) {
  std::uint64_t fingerprint = 0;
  for (std::size_t i = 0; i < 8 && bytes.size() >= 8; ++i) fingerprint = fingerprint << 8 | bytes[i];
  return fingerprint;
}

/// Whether a message says that it is of this type.
template <class Message>
bool Is(std::span<const std::uint8_t> bytes) {
  return bytes.size() >= 8 && Fingerprint(bytes) == static_cast<std::uint64_t>(Message::getHash());
}

/// Decodes a message that anybody may have sent: nothing if its fingerprint, a count or a value is wrong.
template <class Message>
std::optional<Message> Decode(std::span<const std::uint8_t> bytes) {
  if (bytes.size() > std::numeric_limits<std::int32_t>::max()) return std::nullopt;
  if (!Is<Message>(bytes) || !CountsFit<Message>(bytes)) return std::nullopt;
  Message message{};
  if (message.decode(bytes.data(), 0, static_cast<int>(bytes.size())) != static_cast<int>(bytes.size()))
    return std::nullopt;
  if (!ValuesInRange(message)) return std::nullopt;
  return message;
}

}  // namespace crsm
