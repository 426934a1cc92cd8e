#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "services/map_viewer/access.hpp"
#include "services/map_viewer/run_files.hpp"
#include "services/map_viewer/scene.hpp"
#include "services/map_viewer/web_server.hpp"

namespace crsm {

/// What is at which address: the page and its files, what feeds the page, and what feeds Foxglove.
class Site {
 public:
  /// scenes: one for each robot; they outlive the site and its feeds. folders: of finished runs, one for each scene;
  /// none where robots are live.
  Site(std::vector<const Scene*> scenes, Access access, std::vector<std::string> folders = {})
      : scenes_(std::move(scenes)),
        access_(std::move(access)),
        files_(std::make_unique<RunFiles>(std::move(folders))) {}

  WebAnswer Answer(const WebRequest& request) const;

 private:
  WebAnswer AnswerFiles(const WebRequest& request) const;
  WebAnswer AnswerUpgrade(const WebRequest& request) const;
  bool AllowsTokenOf(const WebRequest& request) const;
  std::vector<std::string> Prefixes() const;
  std::unique_ptr<Feed> MakeFoxgloveFeed() const;

  std::vector<const Scene*> scenes_;
  Access access_;
  std::unique_ptr<RunFiles> files_;
};

}  // namespace crsm
