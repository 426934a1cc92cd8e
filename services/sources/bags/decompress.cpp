#include "services/sources/bags/decompress.hpp"

#include <zstd.h>

#include <optional>
#include <span>

#include "common/logs/stop_request.hpp"
#include "services/sources/bags/bag_reader.hpp"
#include "services/sources/unpacker.hpp"

namespace crsm {
namespace {

/// How far bytes could be unpacked.
struct Unpacked {
  std::size_t size = 0;
  bool is_whole = false;
};

/// Nothing if the bytes are damaged or become more than there is room for.
std::optional<Unpacked> UnpackAll(Unpacker& unpacker, std::string_view packed, std::span<char> to) {
  constexpr std::size_t kPieceBytes = std::size_t{1} << 20;
  const std::size_t room = to.size();
  auto state = Unpacker::State::kGoesOn;
  for (bool goes_on = true; goes_on && state == Unpacker::State::kGoesOn && !StopRequested();) {
    const std::size_t before = packed.size() + to.size();
    std::span<char> piece = to.first(std::min(to.size(), kPieceBytes));  // not so long that a signal is not heard
    state = unpacker.Go(packed, piece);
    to = to.last(to.size() - static_cast<std::size_t>(piece.data() - to.data()));
    goes_on = packed.size() + to.size() != before;
  }
  if (state == Unpacker::State::kDamaged || !packed.empty()) return std::nullopt;
  return Unpacked{room - to.size(), state == Unpacker::State::kWhole};
}

}  // namespace

std::unique_ptr<MemoryRange> Decompress(const PackedBytes& packed) {
  if (packed.unpacked_size > kMostChunkBytes || packed.bytes.size() > kMostChunkBytes) return nullptr;
  const auto unpacker = MakeUnpacker(packed.compression);
  if (!unpacker) return nullptr;
  const auto size = static_cast<std::size_t>(packed.unpacked_size);
  std::unique_ptr<char[]> bytes(new char[size]);  // not set to zero: a size that is a lie takes no memory
  const auto unpacked = UnpackAll(*unpacker, packed.bytes, {bytes.get(), size});
  const bool is_good = unpacked && (packed.is_cut || (unpacked->is_whole && unpacked->size == size));
  return is_good ? std::make_unique<MemoryRange>(std::move(bytes), unpacked->size) : nullptr;
}

std::size_t SizeOfZstdMessage(std::string_view message) {
  constexpr std::string_view kMagic = "\x28\xB5\x2F\xFD";  // CDR and ROS 1 messages of ours do not begin so
  if (!message.starts_with(kMagic)) return 0;
  const unsigned long long size = ZSTD_getFrameContentSize(message.data(), message.size());
  return size > kMostMessageBytes ? 0 : static_cast<std::size_t>(size);  // unknown and wrong ones are huge
}

PlainMessage::PlainMessage(std::string_view message) : data_(message) {
  const std::size_t size = SizeOfZstdMessage(message);
  if (size == 0) return;
  unpacked_ = Decompress({"zstd", message, size});
  data_ = unpacked_ ? unpacked_->All() : std::string_view();
}

}  // namespace crsm
