#pragma once

#include <optional>
#include <string>

#include "common/parameters.hpp"

namespace crsm {

/// What a process is told besides the parameters of the algorithm.
struct Settings {
  std::string lcm_url;
  std::string channel_prefix;
  std::string out;
  std::string rate = "1";
  std::string laser_channel;
  std::string laser_frame;
  bool odometry = true;
  bool botlab_clockwise = true;
  bool mirrored = false;
  std::string odometry_topic;
  std::string position;
  bool lockstep = false;
  double map_wait_s = 0.2;
  double resend_s = 0.05;
  std::string journal;
  bool resume = false;
  bool new_session = false;
  bool until_damage = false;
  std::string localize;
  std::string start;
  int part_bytes = 32000;
  double export_period_s = 5.0;
  std::string made_from;
  std::string team;
  std::string http = "127.0.0.1:8765";
};

/// The one list of all settings, as VisitParameters is of the parameters.
template <class Visitor>
void VisitSettings(Settings& s, Visitor&& visit) {
  visit("lcm_url", "URL of the LCM bus; if empty: LCM_DEFAULT_URL of the environment, or else LCM's own default",
        s.lcm_url);
  visit("channel_prefix", "text before every channel name, for example robot1/", s.channel_prefix);
  visit("out", "folder for the results", s.out);
  visit("rate",
        "playback speed: 1: as recorded; N: N times faster; max: as fast as the scans are mapped, and no scan is lost",
        s.rate);
  visit("laser_channel",
        "channel or topic of the laser; if empty: LCM log: the first channel with a laser; bag: the only topic; live: "
        "LASER. slam_offline takes several, 'A,B': drives of their own, of several robots in one log",
        s.laser_channel);
  visit("laser_frame",
        "frame_id of the laser, if several lasers share the channel or topic; for messages of ROS, which have one",
        s.laser_frame);
  visit("odometry",
        "use the wheel odometry of the source, where it has some, as far as it agrees with the laser; what it is worth "
        "is "
        "learned",
        s.odometry);
  visit("botlab_clockwise",
        "the angles of a botlab.lidar_t run clockwise; today's mbot driver needs --no-botlab-clockwise",
        s.botlab_clockwise);
  visit("mirrored",
        "the angles of the laser run the other way than its messages say, or it hangs upside down: turn its scans "
        "round; a log with odometry shows it, if the flag is not given",
        s.mirrored);
  visit("odometry_topic",
        "odometry to use; bag: topic, or frame of TF; LCM log or live: channel; if empty: "
        "bag: the only topic, or odom beside the laser, or TF; LCM: ODOMETRY",
        s.odometry_topic);
  visit("position",
        "file that stores how many scans were published; if it exists, publishing continues after these scans",
        s.position);
  visit("lockstep", "wait for every missing message, instead of continuing without it", s.lockstep);
  visit("map_wait_s", "without --lockstep: longest wait for the map of the last scan [s]", s.map_wait_s, 0.0, 60.0);
  visit("resend_s", "with --rate max: send a scan again if its map does not come within this time [s]", s.resend_s,
        0.01, 60.0);
  visit("journal", "folder of the journal; the journal stores every mapped scan, so that the map can be rebuilt",
        s.journal);
  visit("resume", "continue with the map of the journal", s.resume);
  visit("new_session",
        "with --resume: a session begins, and the robot may stand elsewhere; without it the last session continues, "
        "after a crash for example",
        s.new_session);
  visit("until_damage", "if the journal is damaged in the middle, use the map up to the damage", s.until_damage);
  visit("localize", "folder of an earlier run (its --out): localise on its map without changing it", s.localize);
  visit(
      "start",
      "X,Y,YAW of the laser on the earlier map [m, m, rad]; if empty, with --localize the whole map is searched, with "
      "--resume the robot may stand where the earlier run ended",
      s.start);
  visit("part_bytes",
        "largest MAP_DELTA [bytes], though a tile is never split; use about 1400 on a network that loses packets",
        s.part_bytes, 200, 48000);
  visit("export_period_s", "time between two writes of the results, at least [s]; a large map is written more seldom",
        s.export_period_s, 0.1, 3600.0);
  visit("made_from", "what the map is made from, for people: the log, and the flags that matter", s.made_from);
  visit("team",
        "team that hands in the map: writes map.tif, a GeoTIFF as the RoboCup Rescue League wants it, with this name",
        s.team);
  visit("http", "ADDRESS:PORT where map_viewer shows the map; browsers on other hosts need its token", s.http);
}

/// The factor to real time that a rate says, 0 for max: as fast as scans are mapped. Throws UsageError if it says none.
double ParseRate(const std::string& text);

/// Throws UsageError where channels of the stack with this prefix would be longer than LCM's names.
void CheckPrefix(const std::string& channel_prefix);

/// X,Y,YAW; nothing where there is no text. Throws UsageError if it is something else.
std::optional<Pose2> ParseStart(const std::string& text);

}  // namespace crsm
