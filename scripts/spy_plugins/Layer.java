package crsm.spy;

/** What a map view draws, each to be switched off. */
enum Layer {
  GRID("Grid", "a grid, with the distance of its lines"),
  PATH("Path", "the path of the laser, corrected by the loop closures so far"),
  HITS("Hits", "the hits of the last scan, at its matched pose"),
  CRITICAL_RAYS("Critical rays", "the critical rays; the colour shows what the map has at their ends"),
  UNCERTAINTY("Uncertainty", "an ellipse that holds 95 %, and the degenerate direction"),
  TEXT("Text", "state, pose, and the meaning of the colours");

  final String title;
  final String help;

  Layer(String title, String help) {
    this.title = title;
    this.help = help;
  }
}
