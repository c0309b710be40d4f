// The hold of the stop button, timed apart from the thread that hears the pointer. All times are of the hold [ms].

export const kHold_ms = 500;
export const kUnheard_ms = 100;

/** Calls `ended` once the button was held for kHold_ms. A release before then ends the hold, also one that a busy thread
 *  tells late: the hold's end counts only if the button was told to be held within its last kUnheard_ms. Else the next word
 *  decides. A release within the last kUnheard_ms that comes after the hold's end comes too late. */
export class HoldClock {
  private timer: ReturnType<typeof setTimeout> | undefined;
  private holding = false;
  private told_ms = 0;  // held so long, by the last word

  constructor(private readonly ended: () => void) {}

  /** The button went down `lasted_ms` ago. A release may wait behind this word: it proves no hold. */
  press(lasted_ms: number): void {
    this.stop();
    this.holding = true;
    this.told_ms = 0;
    this.timer = setTimeout(() => {
      if (this.told_ms >= kHold_ms - kUnheard_ms) this.end();
    }, Math.max(0, kHold_ms - lasted_ms));
  }

  /** The button is still down. */
  held(lasted_ms: number): void {
    this.told_ms = lasted_ms;
    if (this.holding && lasted_ms >= kHold_ms) this.end();
  }

  release(lasted_ms: number): void {
    if (this.holding && lasted_ms >= kHold_ms) this.end();
    this.stop();
  }

  private end(): void {
    this.stop();
    this.ended();
  }

  private stop(): void {
    clearTimeout(this.timer);
    this.holding = false;
  }
}
