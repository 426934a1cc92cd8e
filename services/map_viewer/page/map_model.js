// The map as the page holds it: tiles of cells, and pictures of them, a canvas for each block of 8 x 8 tiles.

import {unpackRuns} from "./wire.js";

const TILE_CELLS = 64;
const BLOCK_TILES = 8;
export const BLOCK_CELLS = TILE_CELLS * BLOCK_TILES;
const UNEXPLORED = 127;

// 256 colours, by what a cell's byte is: 255 free .. 0 occupied.
export function makePalette(free, wall) {
  const palette = new Uint32Array(256);
  const bytes = new Uint8Array(palette.buffer);
  for (let value = 0; value < 256; ++value) {
    if (value === UNEXPLORED) continue;
    const is_free = value > UNEXPLORED;
    const [colour, share] = is_free ? [free, (value - UNEXPLORED) / 128] : [wall, (UNEXPLORED - value) / 127];
    bytes.set(colour, 4 * value);
    bytes[4 * value + 3] = Math.round(255 * Math.min(1, 0.25 + 0.75 * share));
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
    this.blocks = new Map();  // "x,y": {x, y, canvas}, made when drawn
    this.stale = new Set();   // tiles whose picture is old
    this.bounds = null;       // in tiles: {x0, y0, x1, y1}, both ends included
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
      const {x0, y0, x1, y1} = this.bounds ?? {x0: x, y0: y, x1: x, y1: y};
      this.bounds = {x0: Math.min(x0, x), y0: Math.min(y0, y), x1: Math.max(x1, x), y1: Math.max(y1, y)};
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
    if (!this.bounds) return null;
    const size = TILE_CELLS * this.cell_size_m;
    const {x0, y0, x1, y1} = this.bounds;
    return {x0: x0 * size, y0: y0 * size, x1: (x1 + 1) * size, y1: (y1 + 1) * size};
  }

  area_m2() { return this.num_explored * this.cell_size_m ** 2; }

  // Brings the pictures up to date. A picture's first row is the block's highest.
  paint() {
    for (const key of this.stale) {
      const tile = this.tiles.get(key);
      const block = this.block(Math.floor(tile.x / BLOCK_TILES), Math.floor(tile.y / BLOCK_TILES));
      const image = paintTile(tile.cells, this.palette);
      const column = (tile.x - block.x * BLOCK_TILES) * TILE_CELLS;
      const row = (BLOCK_TILES - 1 - (tile.y - block.y * BLOCK_TILES)) * TILE_CELLS;
      block.context.putImageData(image, column, row);
    }
    this.stale.clear();
  }

  block(x, y) {
    const key = `${x},${y}`;
    let block = this.blocks.get(key);
    if (!block) {
      const canvas = document.createElement("canvas");
      canvas.width = canvas.height = BLOCK_CELLS;
      block = {x, y, canvas, context: canvas.getContext("2d")};
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
      context.putImageData(paintTile(tile.cells, GREY), tile.x * TILE_CELLS - x0,
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

const tile_image = new ImageData(TILE_CELLS, TILE_CELLS);
const tile_pixels = new Uint32Array(tile_image.data.buffer);

function paintTile(cells, palette) {
  for (let row = 0; row < TILE_CELLS; ++row) {
    const from = (TILE_CELLS - 1 - row) * TILE_CELLS;
    for (let column = 0; column < TILE_CELLS; ++column) {
      tile_pixels[row * TILE_CELLS + column] = palette[cells[from + column]];
    }
  }
  return tile_image;
}
