// When a picture is drawn in a hurry, and when whole.

// Where a whole picture takes so long, ms, those that follow each other are drawn in a hurry, and
// after so long without another comes the whole one.
const SLOW = 30;
const CALM = 400;

export class Hurry {
  constructor() {
    Object.assign(this, { cost: 0, drew: false, isOn: false, last: 0 });
  }

  // Begins a frame; whether a whole picture is due because nothing moves any more.
  begin(now, painter) {
    // A picture that is not done yet keeps the next frame waiting. What whole ones cost is
    // forgotten slowly while none are drawn, lest one moment of a busy machine counts for ever.
    if (this.drew) this.cost = this.isOn ? 0.99 * this.cost : 0.7 * this.cost + 0.3 * (now - this.last);
    this.drew = false;
    this.isCalm = this.isOn && now - this.last > CALM && !painter.hurriesAlways;
    return this.isCalm;
  }

  // Whether the next picture is one in a hurry.
  is(painter) {
    return painter.hurriesAlways || (!this.isCalm && (painter.hurriesMoving || this.cost > SLOW));
  }

  // A picture is drawn.
  end(now, isOn) {
    Object.assign(this, { drew: true, isOn, last: now });
  }
}
