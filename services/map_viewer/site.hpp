#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "services/map_viewer/access.hpp"
#include "services/map_viewer/scene.hpp"
#include "services/map_viewer/web_server.hpp"

namespace crsm {

/// What is at which address: the page and its files, what feeds the page, and what feeds Foxglove.
class Site {
 public:
  /// scenes: one for each robot; they outlive the site and its feeds.
  Site(std::vector<const Scene*> scenes, Access access) : scenes_(std::move(scenes)), access_(std::move(access)) {}

  WebAnswer Answer(const WebRequest& request) const;

 private:
  WebAnswer AnswerUpgrade(const WebRequest& request) const;
  std::vector<std::string> Prefixes() const;
  std::unique_ptr<Feed> MakeFoxgloveFeed() const;

  std::vector<const Scene*> scenes_;
  Access access_;
};

}  // namespace crsm
