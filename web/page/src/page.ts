// SPDX-License-Identifier: BSD-3-Clause
import {LitElement} from 'lit';
import {Bench} from './bench.ts';
import type {Source} from './source.ts';

export type Camera = 'orbit' | 'follow' | 'chase' | 'top';

/** Something that the user is asked before it is done. */
export interface Question {
  text: string;
  yes: string;
  until_s: number;
  /** Whom it is about: it ends when another vehicle is looked at. */
  vehicle?: number;
  act: (vehicle: number | undefined) => void;
}

/** State shared by all parts of the page. */
export class Page {
  readonly bench = new Bench();
  source!: Source;
  camera: Camera = 'follow';
  tab = 'Messages';
  secondTab = 'Plots';
  /** Fields that the user has put on a plot of their own: "MESSAGE.field". */
  readonly picked: string[] = [];
  question?: Question;
  /** The vehicle's own words of the last refusal. */
  refusal = '';
  /** Commands under way: method -> when it began, s. */
  readonly underWay = new Map<string, number>();
  goto: {vehicle?: number; north_m: number; east_m: number; up_m: number} | null = null;
  now_s = 0;
  /** Its first frame is on the screen: slow drawing begins after it. */
  seen = false;
  readonly frames = new Set<(now_s: number) => void>();
  readonly slows = new Set<() => void>();

  /** Draws text: ten times a second, and at once after user input. */
  redraw(): void {
    if (this.question && this.question.vehicle !== this.bench.vehicle?.system) this.question = undefined;
    if (this.goto && this.goto.vehicle !== this.bench.vehicle?.system) this.goto = null;
    for (const slow of this.slows) slow();
  }

  ask(text: string, yes: string, act: Question['act']): void {
    this.refusal = '';
    this.question = {text, yes, until_s: this.now_s + 5, vehicle: this.bench.vehicle?.system, act};
    this.redraw();
  }

  answer(yes: boolean): void {
    const question = this.question;
    this.question = undefined;
    this.goto = null;
    if (yes && question && question.vehicle === this.bench.vehicle?.system) question.act(question.vehicle);
    this.redraw();
  }

  /** Calls a method that changes something, of the selected vehicle unless `params` names one, and keeps the refusal. */
  async command(method: string, params: object = {}): Promise<void> {
    if (this.underWay.has(method)) return;
    this.refusal = '';
    this.underWay.set(method, this.now_s);
    this.redraw();
    try {
      await this.source.call(method, {vehicle: this.bench.vehicle?.system, ...params});
    } catch (error) {
      this.refusal = error instanceof Error ? error.message : String(error);
    }
    this.underWay.delete(method);
    this.redraw();
  }
}

export const page = new Page();

/** A part of the page: one style sheet for all, so it draws into the document itself. */
export class Part extends LitElement {
  private readonly slow_ = () => this.requestUpdate();
  private readonly frame_ = (now_s: number) => this.frame(now_s);

  protected override createRenderRoot(): HTMLElement {
    return this;
  }
  override connectedCallback(): void {
    super.connectedCallback();
    page.slows.add(this.slow_);
    page.frames.add(this.frame_);
  }
  override disconnectedCallback(): void {
    super.disconnectedCallback();
    page.slows.delete(this.slow_);
    page.frames.delete(this.frame_);
  }
  /** Once a frame, for moving parts. */
  protected frame(_now_s: number): void {}
}

/** A canvas in the pixels of the screen; its context draws in CSS pixels. */
export function sized(canvas: HTMLCanvasElement): CanvasRenderingContext2D {
  const ratio = window.devicePixelRatio || 1;
  const [w, h] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
  if (canvas.width !== w || canvas.height !== h) {
    canvas.width = w;
    canvas.height = h;
  }
  const g = canvas.getContext('2d')!;
  g.setTransform(ratio, 0, 0, ratio, 0, 0);
  return g;
}
