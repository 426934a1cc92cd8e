#include "services/map_viewer/site.hpp"

#include <algorithm>
#include <optional>

#include "common/math/parse_number.hpp"
#include "services/map_viewer/foxglove_feed.hpp"
#include "services/map_viewer/foxglove_scene.hpp"
#include "services/map_viewer/page_feed.hpp"
#include "services/map_viewer/page_files.hpp"

namespace crsm {
namespace {

constexpr const char* kLayout = "/foxglove-layout.json";
constexpr const char* kFiles = "/files";

std::string ContentTypeOf(std::string_view name) {
  if (name.ends_with(".html")) return "text/html; charset=utf-8";
  if (name.ends_with(".css")) return "text/css; charset=utf-8";
  if (name.ends_with(".svg")) return "image/svg+xml";
  if (name.ends_with(".json")) return "application/json";
  return "text/javascript; charset=utf-8";
}

std::string_view PathOf(const WebRequest& request) {
  return std::string_view(request.target).substr(0, request.target.find('?'));
}

WebPage FindFile(const WebRequest& request) {
  const std::string_view path = PathOf(request);
  const std::string_view name = path == "/" ? "index.html" : path.substr(std::min<std::size_t>(1, path.size()));
  for (const PageFile& file : kPageFiles) {
    if (file.name == name) return {200, ContentTypeOf(name), std::string(file.text)};
  }
  return Refuse(404, "not found");
}

WebPage RefuseToken() { return Refuse(401, "token: missing or wrong; the viewer printed it when it started"); }

WebPage RefuseRobot() { return Refuse(404, "robot, piece: nothing has this number"); }

/// 0 where the query has no such number.
std::int64_t FindNumber(const WebRequest& request, std::string_view key) {
  return ParseNumber<std::int64_t>(FindInQuery(request.target, key).value_or("")).value_or(0);
}

bool Knows(const WebRequest& request, std::string_view subprotocol) {
  return std::count(request.subprotocols.begin(), request.subprotocols.end(), subprotocol) > 0;
}

}  // namespace

Site::Site(std::vector<const Scene*> scenes, Access access, std::vector<std::string> folders,
           std::vector<ShownPiece> pieces)
    : scenes_(std::move(scenes)), num_robots_(scenes_.size()), pieces_(std::move(pieces)), access_(std::move(access)) {
  for (const ShownPiece& shown : pieces_) {
    scenes_.push_back(shown.scene);
    folders.push_back(shown.scene->name());
  }
  files_ = std::make_unique<RunFiles>(std::move(folders));
}

WebAnswer Site::Answer(const WebRequest& request) const {
  if (!access_.AllowsHost(request.host)) return Refuse(403, "Host: not a name of this viewer");
  if (request.is_upgrade) return AnswerUpgrade(request);
  if (request.origin && !Access::AllowsOrigin(*request.origin, request.host, false))
    return Refuse(403, "Origin: not this viewer");
  if (request.method != "GET" && request.method != "HEAD") return Refuse(405, "method: only GET and HEAD are allowed");
  if (request.target == kLayout) return WebPage{200, ContentTypeOf(kLayout), MakeFoxgloveLayout(Prefixes())};
  if (PathOf(request) == kFiles || PathOf(request).starts_with(std::string(kFiles) + '/')) return AnswerFiles(request);
  return FindFile(request);
}

/// What a run has measured is for those alone who may see its map.
WebAnswer Site::AnswerFiles(const WebRequest& request) const {
  // A browser may ask for a page of another site, without an Origin.
  if (!request.fetch_site.empty() && request.fetch_site != "same-origin" && request.fetch_site != "none") {
    return Refuse(403, "Sec-Fetch-Site: not this viewer");
  }
  if (!AllowsTokenOf(request)) return RefuseToken();
  const auto scene = FindScene(request);
  if (!scene) return RefuseRobot();
  const std::string_view path = PathOf(request);
  if (path == kFiles) return files_->List(*scene);
  const std::string_view name = path.substr(std::string_view(kFiles).size() + 1);
  if (name == RunFiles::kEditedMap && scenes_[*scene]->writes_edits()) {
    return Refuse(503, "the edited map is being written; try again in a moment");
  }
  return files_->Find(*scene, name);
}

/// Its number among scenes_. Without a piece, or with piece 0, it is what is shown of the robot first.
std::optional<std::size_t> Site::FindScene(const WebRequest& request) const {
  const auto robot = static_cast<std::uint64_t>(FindNumber(request, "robot"));
  const std::int64_t piece = FindNumber(request, "piece");
  if (piece == 0) return robot < num_robots_ ? std::optional(robot) : std::nullopt;
  const auto found = std::ranges::find_if(
      pieces_, [&](const ShownPiece& shown) { return shown.robot == robot && shown.piece == piece; });
  if (found == pieces_.end()) return std::nullopt;
  return num_robots_ + static_cast<std::size_t>(found - pieces_.begin());
}

bool Site::AllowsTokenOf(const WebRequest& request) const {
  return access_.AllowsToken(FindInQuery(request.target, "token").value_or(""));
}

/// Before the topics of each scene, in Foxglove's names.
std::vector<std::string> Site::Prefixes() const {
  if (num_robots_ == 1) return {""};
  std::vector<std::string> prefixes;
  for (std::size_t i = 0; i < num_robots_; ++i) {
    const std::string& name = scenes_[i]->name();
    prefixes.push_back(name + (name.ends_with('/') ? "" : "/"));
  }
  return prefixes;
}

std::unique_ptr<Feed> Site::MakeFoxgloveFeed() const {
  const std::vector<std::string> prefixes = Prefixes();
  std::vector<FoxgloveScene> scenes;
  for (std::size_t i = 0; i < num_robots_; ++i) scenes.emplace_back(*scenes_[i], prefixes[i]);
  return std::make_unique<FoxgloveFeed>(std::move(scenes));
}

WebAnswer Site::AnswerUpgrade(const WebRequest& request) const {
  const bool page = Knows(request, PageFeed::kSubprotocol);
  if (request.origin && !Access::AllowsOrigin(*request.origin, request.host, !page)) {
    return Refuse(403, "Origin: neither this viewer nor one that it knows");
  }
  if (!AllowsTokenOf(request)) return RefuseToken();
  for (const char* subprotocol : FoxgloveFeed::kSubprotocols) {
    if (!page && Knows(request, subprotocol)) return WebFeed{subprotocol, MakeFoxgloveFeed()};
  }
  if (!page) return Refuse(400, "Sec-WebSocket-Protocol: none that this viewer supports");
  const auto scene = FindScene(request);
  if (!scene) return RefuseRobot();
  std::vector<std::string> names;
  for (std::size_t i = 0; i < num_robots_; ++i) names.push_back(scenes_[i]->name());
  const PageFeed::Cursor cursor{FindNumber(request, "epoch"), FindNumber(request, "version")};
  const bool may_change = access_.AllowsChange(FindInQuery(request.target, "token").value_or(""));
  return WebFeed{PageFeed::kSubprotocol,
                 std::make_unique<PageFeed>(*scenes_[*scene], std::move(names), cursor, may_change)};
}

}  // namespace crsm
