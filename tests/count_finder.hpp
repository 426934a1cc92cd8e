#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <type_traits>
#include <vector>

#include "services/wire/wire_reader.hpp"

namespace crsm {

using Bytes = std::vector<std::uint8_t>;

/// Where the counts of arrays and strings stand in an encoded message.
class CountFinder {
 public:
  template <class Message>
  void Visit(const Message& message) {
    FieldsOf<Message>::Visit([&](const auto& field) { VisitField(message, field); });
  }

  const std::map<std::size_t, std::int32_t>& counts() const { return counts_; }  ///< by the place of their first byte

 private:
  template <class Message, class Value>
  void VisitField(const Message& message, Value Message::*member) {
    place_of_[&(message.*member)] = at_;
    VisitValue(message.*member);
  }

  template <class Message, class Element, class Count>
  void VisitField(const Message& message, const ArrayField<Message, Element, Count>& array) {
    counts_[place_of_.at(&(message.*array.count))] = message.*array.count;
    for (const Element& element : message.*array.elements) VisitValue(element);
  }

  template <class Value>
  void VisitValue(const Value& value) {
    if constexpr (std::is_same_v<Value, std::string>) {
      counts_[at_] = static_cast<std::int32_t>(value.size()) + 1;
      at_ += 4 + value.size() + 1;
    } else if constexpr (std::is_class_v<Value>) {
      Visit(value);
    } else {
      at_ += sizeof(Value);
    }
  }

  std::size_t at_ = 8;  // behind the fingerprint
  std::map<const void*, std::size_t> place_of_;
  std::map<std::size_t, std::int32_t> counts_;
};

inline std::int32_t ReadCount(const Bytes& bytes, std::size_t at) {
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < 4; ++i) count = count << 8 | bytes[at + i];
  return static_cast<std::int32_t>(count);
}

inline Bytes WithCount(Bytes bytes, std::size_t at, std::int32_t count) {
  for (std::size_t i = 0; i < 4; ++i) {
    bytes[at + i] = static_cast<std::uint8_t>(static_cast<std::uint32_t>(count) >> (24 - 8 * i));
  }
  return bytes;
}

}  // namespace crsm
