// SPDX-License-Identifier: BSD-3-Clause
import {html, nothing} from 'lit';
import {page, Part} from './page.ts';
import {StickPace, sticksOf} from './stick_pace.ts';

/** Hands the sticks of a gamepad to the vehicle while the page is looked at. */
class Sticks extends Part {
  private readonly pace = new StickPace();
  private vehicle?: number;
  /** Place of the gamepad that was asked for, and of no other. */
  private pad?: number;
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
    if (!this.pace.on && (!anyPad() || page.bench.interlock || page.question)) return nothing;
    return html`<div class="btns"><button aria-pressed=${this.pace.on} @click=${this.toggle}>${this.pace.on ? 'Let go of the sticks' : 'Sticks'}</button></div>`;
  }

  private readonly toggle = () => {
    if (this.pace.on) {
      this.pace.stop();
      return this.requestUpdate();
    }
    const pad = anyPad()?.index;
    page.ask(`Fly vehicle ${page.bench.vehicle?.system} by the gamepad?`, 'Fly', (vehicle) => void this.take(vehicle, pad));
  };

  private async take(vehicle: number | undefined, pad: number | undefined): Promise<void> {
    try {
      await page.source.call('pilot.take', {vehicle});
      const {bench} = page;
      if (!this.isConnected || document.hidden || bench.interlock || bench.vehicle?.system !== vehicle) return;
      this.vehicle = vehicle;
      this.pad = pad;
      this.pace.start(page.now_s);
    } catch (error) {
      page.refusal = error instanceof Error ? error.message : String(error);
    }
    page.redraw();
  }

  protected override frame(now_s: number): void {
    const pad = padAt(this.pad);
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

function isUsable(pad: Gamepad | null | undefined): pad is Gamepad {
  return pad?.mapping === 'standard' && pad.connected && pad.axes.length >= 4;
}

function anyPad(): Gamepad | undefined {
  return navigator.getGamepads?.().find(isUsable) ?? undefined;
}

function padAt(index: number | undefined): Gamepad | undefined {
  const pad = index === undefined ? undefined : navigator.getGamepads?.()[index];
  return isUsable(pad) ? pad : undefined;
}
