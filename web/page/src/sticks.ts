// SPDX-License-Identifier: BSD-3-Clause
import {html, nothing} from 'lit';
import {page, Part} from './page.ts';
import {StickPace, sticksOf} from './stick_pace.ts';

/** Hands the sticks of a gamepad to the vehicle while the page is looked at. */
class Sticks extends Part {
  private readonly pace = new StickPace();
  private vehicle?: number;
  private wasOn = false;
  /** A hidden tab draws no frame and sends nothing; it does not take them again by itself. */
  private readonly onHidden = () => this.pace.stop();

  override connectedCallback(): void {
    super.connectedCallback();
    document.addEventListener('visibilitychange', this.onHidden);
  }
  override disconnectedCallback(): void {
    super.disconnectedCallback();
    document.removeEventListener('visibilitychange', this.onHidden);
    this.pace.stop();
  }

  protected override render() {
    if (!gamepad() && !this.pace.on) return nothing;
    return html`<div class="btns"><button aria-pressed=${this.pace.on} @click=${this.toggle}>${this.pace.on ? 'Let go of the sticks' : 'Sticks'}</button></div>`;
  }

  private readonly toggle = () => {
    if (this.pace.on) {
      this.pace.stop();
      return this.requestUpdate();
    }
    const vehicle = page.bench.vehicle?.system;
    page.ask(`Fly vehicle ${vehicle} by the gamepad?`, 'Fly', () => void this.take(vehicle));
  };

  private async take(vehicle: number | undefined): Promise<void> {
    try {
      await page.source.call('pilot.take', {vehicle});
      this.vehicle = vehicle;
      this.pace.start(page.now_s);
    } catch (error) {
      page.refusal = error instanceof Error ? error.message : String(error);
    }
    page.redraw();
  }

  protected override frame(now_s: number): void {
    const pad = gamepad();
    if (this.pace.on && (!pad || page.bench.interlock || this.vehicle !== page.bench.vehicle?.system)) this.pace.stop();
    if (this.pace.tick(now_s)) {
      page.source.call('vehicle.manual_control', {vehicle: this.vehicle, ...sticksOf(pad!.axes)}).then(() => this.pace.answered(), (error: unknown) => {
        this.pace.stop();
        page.refusal = error instanceof Error ? error.message : String(error);
      });
    }
    if (this.wasOn && !this.pace.on) page.refusal ||= 'The sticks were let go.';
    this.wasOn = this.pace.on;
  }
}
customElements.define('cas-sticks', Sticks);

function gamepad(): Gamepad | undefined {
  return navigator.getGamepads?.().find((pad) => pad?.mapping === 'standard' && pad.axes.length >= 4) ?? undefined;
}
