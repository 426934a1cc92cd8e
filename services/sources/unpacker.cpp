#include "services/sources/unpacker.hpp"

#include <bzlib.h>
#include <lz4frame.h>
#include <lzma.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <stdexcept>

namespace crsm {
namespace {

using State = Unpacker::State;

constexpr std::string_view kBzip2Start = "BZh";
constexpr std::string_view kGzipStart = "\x1f\x8b";
constexpr std::string_view kLz4Start = "\x04\x22\x4d\x18";
constexpr std::string_view kXzStart("\xfd\x37zXZ\0", 6);
constexpr std::string_view kZstdStart = "\x28\xb5\x2f\xfd";

[[noreturn]] void FailToBegin(const char* library) {
  throw std::runtime_error(std::string("cannot unpack: ") + library + " has no memory");
}

/// What the libraries that zlib was the model of have in common: next_in, avail_in, next_out, avail_out.
template <class Stream>
class StreamView {
 public:
  StreamView(Stream& stream, std::string_view& packed, std::span<char>& to)
      : stream_(stream), packed_(packed), to_(to) {
    using Byte = std::remove_pointer_t<decltype(stream.next_out)>;
    const auto limit = [](std::size_t size) { return std::min<std::size_t>(size, 1U << 30); };  // some count in 32 bits
    stream.next_in = reinterpret_cast<decltype(stream.next_in)>(const_cast<char*>(packed.data()));
    stream.avail_in = static_cast<decltype(stream.avail_in)>(num_in_ = limit(packed.size()));
    stream.next_out = reinterpret_cast<Byte*>(to.data());
    stream.avail_out = static_cast<decltype(stream.avail_out)>(num_out_ = limit(to.size()));
  }
  ~StreamView() {
    packed_.remove_prefix(num_in_ - stream_.avail_in);
    to_ = to_.subspan(num_out_ - stream_.avail_out);
  }
  StreamView(const StreamView&) = delete;

 private:
  Stream& stream_;
  std::string_view& packed_;
  std::span<char>& to_;
  std::size_t num_in_ = 0;
  std::size_t num_out_ = 0;
};

/// end, good, waits: the library's codes for the end of a stream, for a call that moved on and for one that could not.
template <class Code>
State StateOf(Code code, Code end, Code good, Code waits) {
  return code == end ? State::kWhole : code == good || code == waits ? State::kGoesOn : State::kDamaged;
}

/// A library that ends with each stream, and has to begin anew for the next one. Zeros behind a stream are no matter:
/// xz and some tools fill the file up.
template <class Library>
class StreamByStream : public Unpacker {
 public:
  State Go(std::string_view& packed, std::span<char>& to) override {
    if (ended_ && !packed.empty()) {
      packed.remove_prefix(std::min(packed.find_first_not_of('\0'), packed.size()));
      if (packed.empty()) return State::kWhole;
      if (!packed.starts_with(Library::Start().substr(0, packed.size()))) return State::kDamaged;
      library_ = std::make_unique<Library>();
      ended_ = false;
    }
    const State state = ended_ ? State::kWhole : library_->Go(packed, to);
    ended_ = state == State::kWhole;
    return ended_ && !packed.empty() ? State::kGoesOn : state;
  }

 private:
  std::unique_ptr<Library> library_ = std::make_unique<Library>();
  bool ended_ = false;
};

class Bzip2 {
 public:
  static std::string_view Start() { return kBzip2Start; }
  Bzip2() {
    if (BZ2_bzDecompressInit(&stream_, 0, 0) != BZ_OK) FailToBegin("bzip2");
  }
  ~Bzip2() { BZ2_bzDecompressEnd(&stream_); }
  Bzip2(const Bzip2&) = delete;

  State Go(std::string_view& packed, std::span<char>& to) {
    const StreamView view(stream_, packed, to);
    return StateOf(BZ2_bzDecompress(&stream_), BZ_STREAM_END, BZ_OK, BZ_OK);
  }

 private:
  bz_stream stream_{};
};

class Gzip {
 public:
  static std::string_view Start() { return kGzipStart; }
  Gzip() {
    constexpr int kGzipOnly = 16;
    if (inflateInit2(&stream_, MAX_WBITS + kGzipOnly) != Z_OK) FailToBegin("zlib");
  }
  ~Gzip() { inflateEnd(&stream_); }
  Gzip(const Gzip&) = delete;

  State Go(std::string_view& packed, std::span<char>& to) {
    const StreamView view(stream_, packed, to);
    return StateOf(inflate(&stream_, Z_NO_FLUSH), Z_STREAM_END, Z_OK, Z_BUF_ERROR);
  }

 private:
  z_stream stream_{};
};

class Xz {
 public:
  static std::string_view Start() { return kXzStart; }
  Xz() {
    constexpr std::uint64_t kMostMemory = std::uint64_t{1} << 30;  // of a dictionary: xz -9 takes 65 MB
    if (lzma_stream_decoder(&stream_, kMostMemory, 0) != LZMA_OK) FailToBegin("liblzma");
  }
  ~Xz() { lzma_end(&stream_); }
  Xz(const Xz&) = delete;

  State Go(std::string_view& packed, std::span<char>& to) {
    const StreamView view(stream_, packed, to);
    return StateOf(lzma_code(&stream_, LZMA_RUN), LZMA_STREAM_END, LZMA_OK, LZMA_BUF_ERROR);
  }

 private:
  lzma_stream stream_ = LZMA_STREAM_INIT;
};

/// Goes on to the next frame by itself.
class Lz4 : public Unpacker {
 public:
  Lz4() {
    if (LZ4F_isError(LZ4F_createDecompressionContext(&context_, LZ4F_VERSION))) FailToBegin("lz4");
  }
  ~Lz4() override { LZ4F_freeDecompressionContext(context_); }
  Lz4(const Lz4&) = delete;

  State Go(std::string_view& packed, std::span<char>& to) override {
    std::size_t num_in = packed.size();
    std::size_t num_out = to.size();
    if (num_in == 0 && hint_ == 0) return State::kWhole;
    hint_ = LZ4F_decompress(context_, to.data(), &num_out, packed.data(), &num_in, nullptr);
    if (LZ4F_isError(hint_)) return State::kDamaged;
    packed.remove_prefix(num_in);
    to = to.subspan(num_out);
    return hint_ == 0 && packed.empty() ? State::kWhole : State::kGoesOn;
  }

 private:
  LZ4F_dctx* context_ = nullptr;
  std::size_t hint_ = 1;  ///< 0 at the end of a frame
};

/// Likewise.
class Zstd : public Unpacker {
 public:
  Zstd() : context_(ZSTD_createDCtx(), &ZSTD_freeDCtx) {
    if (!context_) FailToBegin("zstd");
  }

  State Go(std::string_view& packed, std::span<char>& to) override {
    ZSTD_inBuffer in{packed.data(), packed.size(), 0};
    ZSTD_outBuffer out{to.data(), to.size(), 0};
    if (packed.empty() && hint_ == 0) return State::kWhole;
    hint_ = ZSTD_decompressStream(context_.get(), &out, &in);
    if (ZSTD_isError(hint_)) return State::kDamaged;
    packed.remove_prefix(in.pos);
    to = to.subspan(out.pos);
    return hint_ == 0 && packed.empty() ? State::kWhole : State::kGoesOn;
  }

 private:
  std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context_;
  std::size_t hint_ = 1;  ///< 0 at the end of a frame
};

template <class Kind>
std::unique_ptr<Unpacker> Make() {
  return std::make_unique<Kind>();
}

struct Compression {
  std::string_view name;
  std::string_view start;
  std::unique_ptr<Unpacker> (*make)();
};

constexpr std::array<Compression, 5> kCompressions{{{"bz2", kBzip2Start, &Make<StreamByStream<Bzip2>>},
                                                    {"gzip", kGzipStart, &Make<StreamByStream<Gzip>>},
                                                    {"lz4", kLz4Start, &Make<Lz4>},
                                                    {"xz", kXzStart, &Make<StreamByStream<Xz>>},
                                                    {"zstd", kZstdStart, &Make<Zstd>}}};

}  // namespace

std::unique_ptr<Unpacker> MakeUnpacker(std::string_view compression) {
  const auto found = std::ranges::find(kCompressions, compression, &Compression::name);
  return found == kCompressions.end() ? nullptr : found->make();
}

std::string FindCompression(std::string_view start) {
  const auto found =
      std::ranges::find_if(kCompressions, [&](const Compression& kind) { return start.starts_with(kind.start); });
  return found == kCompressions.end() ? "" : std::string(found->name);
}

}  // namespace crsm
