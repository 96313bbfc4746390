// SPDX-License-Identifier: BSD-3-Clause
import {html} from 'lit';
import {kStale_s} from './bench.ts';
import {age, fixed} from './numbers.ts';
import {page, Part, sized} from './page.ts';
import {colour, themeListeners} from './theme.ts';

const kPanel = '#0b121b';
const kDegrees = 180 / Math.PI;

/** Artificial horizon with speed, height, heading and climb: the truth, else the estimate. */
class Horizon extends Part {
  private colours = {sky: '', ground: ''};
  private drawn = '';
  private readonly onTheme = () => {
    this.colours = {sky: colour('pfs'), ground: colour('pfg')};
  };

  override connectedCallback(): void {
    super.connectedCallback();
    themeListeners.add(this.onTheme);
    this.onTheme();
  }
  override disconnectedCallback(): void {
    super.disconnectedCallback();
    themeListeners.delete(this.onTheme);
  }

  protected override render() {
    const shown = page.bench.motion();
    const m = shown?.motion;
    const text = m
      ? `Attitude, ${shown.label}: roll ${fixed(m.rpy.roll * kDegrees, 0)}, pitch ${fixed(m.rpy.pitch * kDegrees, 0)}, ` +
        `heading ${fixed(heading(m.rpy.yaw), 0)} degrees; ${fixed(m.p[2])} m up, ${fixed(Math.hypot(m.vel[0], m.vel[1]))} m/s`
      : 'Attitude: nothing known';
    return html`<canvas class="horizon" role="img" aria-label=${text}></canvas>`;
  }

  protected override frame(): void {
    const canvas = this.querySelector('canvas');
    if (!page.seen || !canvas || canvas.clientWidth === 0) return;
    const g = sized(canvas);
    const [W, H] = [canvas.clientWidth, canvas.clientHeight];
    const shown = page.bench.motion();
    const old = page.bench.estimate()?.age_s ?? 0;
    const key = `${W}x${H}|${this.colours.sky}|${shown?.motion.p.join()}|${shown?.motion.q.join()}|${shown?.motion.vel.join()}|${
      shown?.label}|${Math.round(old * 10)}|${Math.round((shown?.motion.age_s ?? 0) * 10)}`;
    if (key === this.drawn) return;  // nothing moved
    this.drawn = key;
    g.save();
    g.beginPath();
    g.roundRect(0, 0, W, H, 7);
    g.clip();
    g.fillStyle = kPanel;
    g.fillRect(0, 0, W, H);
    const [cx, cy, perDegree] = [W / 2, H / 2 - 10, H / 34];
    if (shown) {
      const {rpy} = shown.motion;
      this.drawSky(g, cx, cy, perDegree, rpy.roll, rpy.pitch * kDegrees);
      this.drawEstimate(g, cx, cy, perDegree, shown.label);
      this.drawRoll(g, cx, cy, H * 0.36, rpy.roll);
    }
    drawWings(g, cx, cy);
    const m = shown?.motion;
    drawTape(g, 0, 46, cy, H, m && Math.hypot(m.vel[0], m.vel[1]), false);
    drawTape(g, W - 46, 46, cy, H, m?.p[2], true);
    this.drawFoot(g, W, H, shown);
    g.restore();
  }

  private drawSky(g: CanvasRenderingContext2D, cx: number, cy: number, perDegree: number, roll: number, pitch: number): void {
    g.save();
    g.translate(cx, cy);
    g.rotate(-roll);
    g.translate(0, pitch * perDegree);
    g.fillStyle = this.colours.sky;
    g.fillRect(-600, -900, 1200, 900);
    g.fillStyle = this.colours.ground;
    g.fillRect(-600, 0, 1200, 900);
    g.strokeStyle = '#fff';
    g.fillStyle = '#fff';
    g.lineWidth = 1.6;
    line(g, -600, 0, 600, 0);
    g.lineWidth = 1.2;
    g.font = '10px ' + colour('sans');
    for (let d = -90; d <= 90; d += 5) {
      if (d === 0 || Math.abs(d - pitch) > 22) continue;
      const half = d % 10 === 0 ? 32 : 16;
      line(g, -half, -d * perDegree, half, -d * perDegree);
      if (d % 10 === 0) g.fillText(String(Math.abs(d)), half + 5, -d * perDegree + 3.5);
    }
    g.restore();
  }

  /** The estimate's own horizon as two short strokes, beside the truth. */
  private drawEstimate(g: CanvasRenderingContext2D, cx: number, cy: number, perDegree: number, label: string): void {
    const estimate = page.bench.estimate();
    if (!estimate || label !== 'truth' || estimate.age_s > kStale_s) return;
    g.save();
    g.translate(cx, cy);
    g.rotate(-estimate.rpy.roll);
    g.translate(0, estimate.rpy.pitch * kDegrees * perDegree);
    g.strokeStyle = '#7cc8ff';
    g.lineWidth = 2;
    line(g, -86, 0, -52, 0);
    line(g, 52, 0, 86, 0);
    g.restore();
  }

  private drawRoll(g: CanvasRenderingContext2D, cx: number, cy: number, radius: number, roll: number): void {
    g.save();
    g.translate(cx, cy);
    g.strokeStyle = 'rgb(255 255 255 / 70%)';
    g.lineWidth = 1;
    g.beginPath();
    g.arc(0, 0, radius, -Math.PI / 2 - 0.78, -Math.PI / 2 + 0.78);
    g.stroke();
    g.strokeStyle = '#fff';
    g.beginPath();
    g.moveTo(0, -radius + 1);
    g.lineTo(-5, -radius + 9);
    g.lineTo(5, -radius + 9);
    g.closePath();
    g.stroke();
    g.rotate(-roll);
    g.fillStyle = '#fff';
    g.beginPath();
    g.moveTo(0, -radius);
    g.lineTo(-5, -radius - 8);
    g.lineTo(5, -radius - 8);
    g.fill();
    g.restore();
  }

  private drawFoot(g: CanvasRenderingContext2D, W: number, H: number, shown: ReturnType<typeof page.bench.motion>): void {
    g.fillStyle = kPanel;
    g.fillRect(0, H - 24, W, 24);
    const font = colour('sans');
    g.font = '10.5px ' + font;
    g.fillStyle = '#c3ccd8';
    g.textAlign = 'left';
    g.fillText('m/s', 8, H - 8);
    g.textAlign = 'right';
    const climb = shown?.motion.vel[2];
    const arrow = climb === undefined ? '' : climb < -0.005 ? '▾ ' : '▴ ';
    g.fillText(`m ${arrow}${climb === undefined ? '' : Math.abs(climb).toFixed(2)}`, W - 8, H - 8);
    g.textAlign = 'center';
    g.font = '600 13px ' + font;
    g.fillStyle = '#fff';
    const yaw = shown && heading(shown.motion.rpy.yaw);
    g.fillText(yaw === undefined ? '–––°' : `${String(Math.round(yaw) % 360).padStart(3, '0')}°`, W / 2, H - 7);
    if (!shown) return;
    g.textAlign = 'left';
    g.font = '600 10.5px ' + font;
    const estimate = page.bench.estimate();
    const old = shown.label === 'truth' && estimate && estimate.age_s > kStale_s ? ` (estimate ${age(estimate.age_s)})` : '';
    const stale = shown.motion.age_s > kStale_s;
    g.fillText(shown.label + (stale ? ` ${age(shown.motion.age_s)}` : old), 54, H - 32);
  }
}

const heading = (yaw: number): number => (((yaw * kDegrees) % 360) + 360) % 360;

function line(g: CanvasRenderingContext2D, x0: number, y0: number, x1: number, y1: number): void {
  g.beginPath();
  g.moveTo(x0, y0);
  g.lineTo(x1, y1);
  g.stroke();
}

function drawWings(g: CanvasRenderingContext2D, cx: number, cy: number): void {
  for (const [colour, width] of [['#111', 5], ['#ffd75e', 2.6]] as const) {
    g.strokeStyle = colour;
    g.lineWidth = width;
    g.beginPath();
    g.moveTo(cx - 46, cy);
    g.lineTo(cx - 20, cy);
    g.lineTo(cx - 12, cy + 8);
    g.moveTo(cx + 46, cy);
    g.lineTo(cx + 20, cy);
    g.lineTo(cx + 12, cy + 8);
    g.stroke();
  }
  g.fillStyle = '#ffd75e';
  g.beginPath();
  g.arc(cx, cy, 2.4, 0, 7);
  g.fill();
}

/** A scale that runs behind a box with the value: half a unit a step, wider when it is large. */
function drawTape(
    g: CanvasRenderingContext2D, x: number, w: number, cy: number, H: number, value: number | undefined, right: boolean): void {
  g.fillStyle = 'rgb(11 18 27 / 72%)';
  g.fillRect(x, 0, w, H - 24);
  const font = colour('sans');
  const step = 0.5;
  const px = 44;
  g.textAlign = right ? 'left' : 'right';
  if (value !== undefined) {
    g.font = '10.5px ' + font;
    g.lineWidth = 1;
    g.strokeStyle = 'rgb(255 255 255 / 70%)';
    g.fillStyle = '#dfe6ee';
    for (let k = Math.floor(value / step) - 5; k <= value / step + 5; ++k) {
      const y = cy - (k * step - value) * px;
      if (y < 8 || y > H - 30 || (!right && k < 0)) continue;
      line(g, right ? x : x + w - 5, y, right ? x + 5 : x + w, y);
      if (Math.abs(y - cy) > 16) g.fillText(fixed(k * step, 1), right ? x + 9 : x + w - 9, y + 3.5);
    }
  }
  g.fillStyle = kPanel;
  g.strokeStyle = 'rgb(255 255 255 / 60%)';
  g.lineWidth = 1;
  g.beginPath();
  g.roundRect(x - (right ? 4 : 0), cy - 12, w + 4, 24, 3);
  g.fill();
  g.stroke();
  g.textAlign = 'right';
  g.font = '600 14px ' + font;
  g.fillStyle = '#fff';
  g.fillText(fixed(value, Math.abs(value ?? 0) >= 100 ? 0 : Math.abs(value ?? 0) >= 10 ? 1 : 2), x + w - (right ? 5 : 4), cy + 5);
}

customElements.define('cas-horizon', Horizon);
