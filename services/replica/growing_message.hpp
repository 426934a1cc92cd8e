#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "services/wire/conversions.hpp"

namespace crsm {

/// What all answers of a map's owner have in common.
struct AnswerOptions {
  std::int64_t epoch = 0;          ///< of its map
  std::size_t most_bytes = 32000;  ///< of a message; a tile stays whole: one alone makes 4.4 KB at most
};

/// A map_delta_t or map_page_t that grows, and its size on the wire.
template <class Message>
class GrowingMessage {
 public:
  explicit GrowingMessage(const Message& blank)
      : message(blank), size(static_cast<std::size_t>(blank.getEncodedSize())) {}

  template <class Item>
  void Add(Item item, std::vector<Item>& list, std::int32_t& count) {
    size += static_cast<std::size_t>(item._getEncodedSizeNoHash());
    list.push_back(std::move(item));
    ++count;
  }

  /// False, and nothing is added, if the message would be larger than `most_bytes`. The first tile always fits.
  bool AddTile(const TileChange& change, std::size_t most_bytes) {
    map_tile_t tile = ToMessage(change);
    const auto tile_size = static_cast<std::size_t>(tile._getEncodedSizeNoHash());
    if (message.num_tiles > 0 && size + tile_size > most_bytes) return false;
    Add(std::move(tile), message.tiles, message.num_tiles);
    return true;
  }

  Message message;
  std::size_t size;
};

}  // namespace crsm
