// CRITICAL_RAYS, SCAN_MATCH, POSE_GRAPH and MAP_REQUEST, as map_updater takes them: its answers must be ones that
// replicas believe.

#include <cstdlib>

#include "common/graph/whole_map.hpp"
#include "input.hpp"
#include "services/map_updater/delta_parts.cpp"  // in no library: it is map_updater's own
#include "services/map_updater/pages.cpp"
#include "services/wire/conversions.hpp"
#include "services/wire/graph_messages.hpp"
#include "tame_pose.hpp"
#include "wire_messages.hpp"

namespace crsm {
namespace {

constexpr AnswerOptions kOptions{99, 1400};
constexpr LoopParameters kLoops{true, 30.0};

void Tame(scan_match_t& match) {
  pose2_t pose{match.x_m, match.y_m, match.yaw_rad};
  Tame(pose);
  match.x_m = pose.x_m;
  match.y_m = pose.y_m;
}

void Check(map_delta_t delta) {
  for (pose2_t& motion : delta.T_new_old) Tame(motion);
  if (!Decode<map_delta_t>(Encode(delta))) std::abort();
}

void Check(map_page_t answer) {
  for (scan_match_t& match : answer.matches) Tame(match);
  for (map_loop_t& loop : answer.loops) {
    Tame(loop.T_map_older);
    Tame(loop.T_map_newer);
  }
  for (map_pieces_t& layout : answer.layout) {
    for (map_break_t& at : layout.breaks) Tame(at.T_map_before);
  }
  for (tracking_state_t& tracking : answer.tracking) {
    Tame(tracking.T_local_map);
    for (scan_match_t& match : tracking.recent) Tame(match);
  }
  if (!Decode<map_page_t>(Encode(answer))) std::abort();
}

/// The map's owner, with loops or without.
class Owner {
 public:
  explicit Owner(bool loops) : loops_(loops), mapper_(UpdateParameters{}, {loops, kLoops.local_map_m}, {.lag = 2}) {}

  void Handle(std::span<const std::uint8_t> bytes) {
    if (const auto rays = Decode<critical_rays_t>(bytes)) scan_ = FromMessage(*rays);
    if (const auto match = Decode<scan_match_t>(bytes)) Answer(FromMessage(*match));
    if (const auto part = Decode<pose_graph_t>(bytes)) Take(*part);
    if (const auto mark = Decode<mark_t>(bytes)) Take(FromMessage(*mark));
    if (const auto kept = Decode<kept_mark_t>(bytes)) marks_.Add(FromMessage(*kept), mapper_);
    if (const auto request = Decode<map_request_t>(bytes)) Answer(*request);
  }

 private:
  void Answer(const ScanMatch& match) {
    const bool matched = scan_ && scan_->utime == match.utime;
    const Mapper::Step step = mapper_.Integrate(matched ? &*scan_ : nullptr, match);
    answered_.Append(match);
    tracking_.Add(match, step.after);
    for (const map_delta_t& part : MakeParts(step.delta, match.utime, local().geometry(), kOptions, step.after)) {
      Check(part);
    }
  }

  void Take(const pose_graph_t& part) {
    if (!loops_ || part.changed == 0) return;
    if (const auto update = parts_.Add(part)) mapper_.Accept(*update);
  }

  void Take(const Mark& mark) {
    const auto fixed =
        mark.in_map_frame ? std::optional(FixOnMap(mark, mapper_))
                          : FixByLaser(mark, answered_.FindUpTo(mark.utime), answered_.FindBehind(mark.utime), mapper_);
    if (fixed && marks_.Judge(*fixed) == MarkBook::Judgement::kNew && !marks_.Add(*fixed, mapper_)) std::abort();
  }

  void AnswerWithPiece(const map_request_t& request) const {
    const int component = mapper_.FindComponent(request.piece);
    std::int64_t num_scans = 0;
    for (const Mapper::ScanRun& run : mapper_.FindScans(component)) num_scans += run.end - run.first;
    WholeMap piece(UpdateParameters{});
    piece.Draw(mapper_, component, num_scans, mapper_.graph().size());
    Check(MakePage(request, piece.map(), {answered_, tracking_, &mapper_, component}, kOptions));
  }

  void Answer(const map_request_t& request) const {
    const auto place_marks = [this] { return marks_.Place(mapper_); };
    if (!loops_ || request.whole == 0) {
      return Check(MakePage(request, local(), {answered_, tracking_, nullptr, {}, place_marks}, kOptions));
    }
    if (request.piece != 0) return AnswerWithPiece(request);
    WholeMap whole(UpdateParameters{});
    whole.Draw(mapper_, mapper_.graph().size());
    Check(MakePage(request, whole.map(), {answered_, tracking_, &mapper_, {}, place_marks}, kOptions));
  }

  const MapUpdater& local() const { return mapper_.local(); }

  bool loops_;
  Mapper mapper_;
  MatchStore answered_;
  TrackingState tracking_;
  MarkBook marks_;
  GraphUpdateParts parts_;
  std::optional<CriticalRays> scan_;
};

}  // namespace
}  // namespace crsm

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crsm;
  for (const bool loops : {false, true}) {
    Owner owner(loops);
    MessageReader messages({data, size});
    while (const auto bytes = messages.Next()) owner.Handle(*bytes);
  }
  return 0;
}
