// The map as the page holds it: tiles of cells, and pictures of them: for each block of 8 x 8 tiles a canvas with a pixel
// a cell, and smaller ones for who looks from afar, in which no wall is lost.

import {unpackRuns} from "./wire.js";

const TILE_CELLS = 64;
const BLOCK_TILES = 8;
export const BLOCK_CELLS = TILE_CELLS * BLOCK_TILES;
export const REDUCTIONS = [1, 4, 16];  // cells beside each other that are one pixel
const UNEXPLORED = 127;
const WALL = 90;  // as map_server takes it: bytes below are occupied

// 256 colours, by what a cell's byte is: 255 free .. 0 occupied. free, wall: red, green, blue; least: how much is seen of
// what is hardly known, and free_share of what is free, 0 to 1.
export function makePalette(free, wall, {least = 0.25, free_share = 1} = {}) {
  const palette = new Uint32Array(256);
  const bytes = new Uint8Array(palette.buffer);
  for (let value = 0; value < 256; ++value) {
    if (value === UNEXPLORED) continue;
    const is_free = value > UNEXPLORED;
    const [colour, share] = is_free ? [free, (value - UNEXPLORED) / 128] : [wall, (UNEXPLORED - value) / 127];
    bytes.set(colour, 4 * value);
    bytes[4 * value + 3] = Math.round(255 * Math.min(1, least + (1 - least) * share) * (is_free ? free_share : 1));
  }
  return palette;
}

// Every cell as its byte says it, as in map.png.
const GREY = Uint32Array.from({length: 256}, (_, value) => (0xff000000 | (value << 16) | (value << 8) | value) >>> 0);

export class MapModel {
  constructor() {
    this.cell_size_m = 0.05;
    this.palette = GREY;
    this.clear();
  }

  clear() {
    this.tiles = new Map();   // "x,y": {x, y, cells}
    this.blocks = new Map();  // "x,y": {x, y, pictures}, made when drawn
    this.stale = new Set();   // tiles whose picture is old
    this.num_explored = 0;    // cells
  }

  setPalette(palette) {
    this.palette = palette;
    for (const key of this.tiles.keys()) this.stale.add(key);
  }

  take({x, y, whole, runs}) {
    const key = `${x},${y}`;
    let tile = this.tiles.get(key);
    if (!tile) {
      tile = {x, y, cells: new Uint8Array(TILE_CELLS * TILE_CELLS).fill(UNEXPLORED), num_explored: 0};
      this.tiles.set(key, tile);
    } else if (whole) {
      tile.cells.fill(UNEXPLORED);
    }
    unpackRuns(runs, tile.cells);
    const num_explored = tile.cells.reduce((sum, cell) => sum + (cell !== UNEXPLORED), 0);
    this.num_explored += num_explored - tile.num_explored;
    tile.num_explored = num_explored;
    this.stale.add(key);
  }

  // The byte of the cell that holds a point.
  at(x_m, y_m) {
    const x = Math.floor(x_m / this.cell_size_m);
    const y = Math.floor(y_m / this.cell_size_m);
    const tile = this.tiles.get(`${x >> 6},${y >> 6}`);
    return tile ? tile.cells[((y & 63) << 6) | (x & 63)] : UNEXPLORED;
  }

  // What a ray hits that ends there: "wall", "free" or "new". A wall may be a cell beside it.
  hit(x_m, y_m) {
    const size = this.cell_size_m;
    for (const [dx, dy] of [[0, 0], [size, 0], [-size, 0], [0, size], [0, -size]]) {
      if (this.at(x_m + dx, y_m + dy) < UNEXPLORED) return "wall";
    }
    return this.at(x_m, y_m) > UNEXPLORED ? "free" : "new";
  }

  // Explored rectangle [m]; null while nothing is.
  extent() {
    const size = TILE_CELLS * this.cell_size_m;
    let extent = null;
    for (const {x, y, num_explored} of this.tiles.values()) {
      if (num_explored === 0) continue;  // of a piece that was shown before
      const {x0, y0, x1, y1} = extent ?? {x0: Infinity, y0: Infinity, x1: -Infinity, y1: -Infinity};
      extent = {x0: Math.min(x0, x * size), y0: Math.min(y0, y * size), x1: Math.max(x1, (x + 1) * size), y1: Math.max(y1, (y + 1) * size)};
    }
    return extent;
  }

  area_m2() { return this.num_explored * this.cell_size_m ** 2; }

  // Brings the pictures up to date. A picture's first row is the block's highest.
  paint() {
    for (const key of this.stale) {
      const tile = this.tiles.get(key);
      const block = this.block(Math.floor(tile.x / BLOCK_TILES), Math.floor(tile.y / BLOCK_TILES));
      let cells = tile.cells;
      REDUCTIONS.forEach((reduction, level) => {
        const side = TILE_CELLS / reduction;
        if (level > 0) cells = reduce(cells, (side * reduction) / REDUCTIONS[level - 1], reduction / REDUCTIONS[level - 1]);
        const column = (tile.x - block.x * BLOCK_TILES) * side;
        const row = (BLOCK_TILES - 1 - (tile.y - block.y * BLOCK_TILES)) * side;
        block.pictures[level].getContext("2d").putImageData(paintCells(cells, side, this.palette), column, row);
      });
    }
    this.stale.clear();
  }

  block(x, y) {
    const key = `${x},${y}`;
    let block = this.blocks.get(key);
    if (!block) {
      block = {x, y, pictures: REDUCTIONS.map((reduction) => {
        const canvas = document.createElement("canvas");
        canvas.width = canvas.height = BLOCK_CELLS / reduction;
        return canvas;
      })};
      this.blocks.set(key, block);
    }
    return block;
  }

  // The map alone, a pixel a cell, with the bytes of map.png; its explored rectangle, too.
  toCanvas() {
    const {x0, y0, x1, y1} = this.exploredCells();
    const canvas = document.createElement("canvas");
    canvas.width = x1 - x0 + 1;
    canvas.height = y1 - y0 + 1;
    const context = canvas.getContext("2d");
    context.fillStyle = `rgb(${UNEXPLORED}, ${UNEXPLORED}, ${UNEXPLORED})`;
    context.fillRect(0, 0, canvas.width, canvas.height);
    for (const tile of this.tiles.values()) {
      context.putImageData(paintCells(tile.cells, TILE_CELLS, GREY), tile.x * TILE_CELLS - x0,
                           y1 + 1 - (tile.y + 1) * TILE_CELLS);
    }
    return canvas;
  }

  exploredCells() {
    const box = {x0: Infinity, y0: Infinity, x1: -Infinity, y1: -Infinity};
    for (const tile of this.tiles.values()) {
      tile.cells.forEach((cell, index) => {
        if (cell === UNEXPLORED) return;
        const x = tile.x * TILE_CELLS + (index & 63);
        const y = tile.y * TILE_CELLS + (index >> 6);
        box.x0 = Math.min(box.x0, x);
        box.y0 = Math.min(box.y0, y);
        box.x1 = Math.max(box.x1, x);
        box.y1 = Math.max(box.y1, y);
      });
    }
    return this.num_explored > 0 ? box : {x0: 0, y0: 0, x1: 0, y1: 0};
  }
}

const images = new Map(REDUCTIONS.map((reduction) => {
  const side = TILE_CELLS / reduction;
  return [side, new ImageData(side, side)];
}));

// The picture of side x side cells, the highest row first.
function paintCells(cells, side, palette) {
  const image = images.get(side);
  const pixels = new Uint32Array(image.data.buffer);
  for (let row = 0; row < side; ++row) {
    const from = (side - 1 - row) * side;
    for (let column = 0; column < side; ++column) pixels[row * side + column] = palette[cells[from + column]];
  }
  return image;
}

// One cell for each square of `factor` cells on a side: its wall if it has one, else what is most surely free.
function reduce(cells, side, factor) {
  const small = side / factor;
  const reduced = new Uint8Array(small * small);
  for (let y = 0; y < small; ++y) {
    for (let x = 0; x < small; ++x) {
      let [wall, free] = [UNEXPLORED, UNEXPLORED];
      for (let dy = 0; dy < factor; ++dy) {
        for (let dx = 0; dx < factor; ++dx) {
          const cell = cells[(y * factor + dy) * side + x * factor + dx];
          if (cell < wall) wall = cell; else if (cell > free) free = cell;
        }
      }
      reduced[y * small + x] = wall < WALL ? wall : free;
    }
  }
  return reduced;
}

// The direction of most walls [rad], -45 to 45 degrees: 0 where they lie along the axes. Walls are where the cells change
// most, and a wall and the one across it count together.
export function findWalls(map) {
  let [cos, sin] = [0, 0];
  for (const {cells} of map.tiles.values()) {
    for (let y = 1; y < TILE_CELLS - 1; ++y) {
      for (let x = 1; x < TILE_CELLS - 1; ++x) {
        const at = y * TILE_CELLS + x;
        if (cells[at] >= WALL) continue;
        const dx = cells[at + 1] - cells[at - 1] + (cells[at + 65] - cells[at - 65] + cells[at - 63] - cells[at + 63]) / 2;
        const dy = cells[at + 64] - cells[at - 64] + (cells[at + 65] - cells[at - 65] + cells[at + 63] - cells[at - 63]) / 2;
        const weight = dx * dx + dy * dy;
        const angle = 4 * Math.atan2(dy, dx);
        cos += weight * Math.cos(angle);
        sin += weight * Math.sin(angle);
      }
    }
  }
  return Math.atan2(sin, cos) / 4;
}
