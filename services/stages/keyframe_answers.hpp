#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "common/graph/loop_closer.hpp"
#include "services/wire/wire.hpp"

namespace crsm {

/// What a loop closer answers to the keyframes of a map's owner. It touches neither network nor clock: messages go in,
/// answers come out, and NextRequest says what it lacks.
///
/// All that it knows follows from the keyframes: one that is started anew asks for them all, and comes to the same
/// answers, without a new search where the owner says what was found. It keeps those that the owner does not have yet.
class KeyframeAnswers {
 public:
  explicit KeyframeAnswers(MakeLoopCloser make_closer)
      : make_closer_(std::move(make_closer)), closer_(make_closer_()) {}

  /// Answers one; nothing where one before it or its constraint's is lacking, or where is_of_another_closer.
  std::vector<pose_graph_t> Answer(const keyframe_t& message);

  /// Asks for some of the keyframes that are lacking; nothing where none are.
  std::optional<keyframe_request_t> NextRequest() const;

  const KeyframeGraph& graph() const { return closer_->graph(); }
  std::optional<KeyframeId> last_update() const {
    return updates_.empty() ? std::nullopt : std::optional(updates_.back());
  }
  /// Keyframes at which loops were searched, because the owner did not tell what was found there.
  std::int64_t num_searched() const { return num_searched_; }
  /// Whether the owner's map was corrected by another loop closer, which found other loops.
  bool is_of_another_closer() const { return is_of_another_closer_; }

 private:
  void Begin(std::int64_t epoch);
  bool Fits(const keyframe_t& message) const;

  MakeLoopCloser make_closer_;
  std::unique_ptr<LoopCloser> closer_;
  std::int64_t epoch_ = 0;
  std::optional<KeyframeId> newest_;          ///< keyframe of which is known that it is there
  std::vector<KeyframeId> updates_;           ///< all of them, by their keyframes
  std::deque<GraphUpdate> kept_;              ///< that the owner does not have, so far as is known
  std::optional<KeyframeId> known_to_owner_;  ///< the last one that it has
  bool is_of_another_closer_ = false;
  std::int64_t num_searched_ = 0;
};

}  // namespace crsm
