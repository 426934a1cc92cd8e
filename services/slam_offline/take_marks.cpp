#include "services/slam_offline/take_marks.hpp"

#include <fmt/format.h>

#include <optional>

namespace crsm {
namespace {

std::optional<FixedMark> Fix(const Mark& mark, const Mapper& mapper, const MatchStore& matches) {
  if (mark.in_map_frame) return FixOnMap(mark, mapper);
  const auto before = matches.FindUpTo(mark.utime);
  const bool is_exact = before && before->match.utime == mark.utime;
  return FixByLaser(mark, before, is_exact ? std::nullopt : matches.FindBehind(mark.utime), mapper);
}

}  // namespace

std::vector<std::string> TakeMarks(const MarksOfFile& file, const Mapper& mapper, const MatchStore& matches,
                                   MarkBook& book, const std::function<void(const FixedMark&)>& keep) {
  std::vector<std::string> left_out;
  for (const auto& [mark, line] : file.marks) {
    const auto LeaveOut = [&, number = line](const std::string& why) {
      left_out.push_back(fmt::format("{}:{}: is left out: {}", file.path, number, why));
    };
    const auto fixed = Fix(mark, mapper, matches);
    if (!fixed) {
      LeaveOut("no scan was matched within 0.5 s of its time");
      continue;
    }
    const auto judgement = book.Judge(*fixed);
    if (judgement == MarkBook::Judgement::kKnown) continue;
    if (judgement != MarkBook::Judgement::kNew) {
      LeaveOut(DescribeJudgement(judgement));
      continue;
    }
    keep(*fixed);
    book.Add(*fixed, mapper);
  }
  return left_out;
}

}  // namespace crsm
