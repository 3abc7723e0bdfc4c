(function () {
  var run = JSON.parse(document.getElementById("run").textContent);
  var bar = document.querySelector(".player"), slider = bar.querySelector("input");
  var play = bar.querySelector(".play"), pace = bar.querySelector(".pace");
  var output = bar.querySelector("output"), now = bar.querySelector(".now");
  var charts = Array.from(document.querySelectorAll(".chart"));
  var heats = Array.from(document.querySelectorAll(".rules .heat"));
  var bodies = Array.from(document.querySelectorAll("#map .robot"));
  var time = run.end_s, speeds = [1, 2, 4, 8, 16], speed = 4, going = false, last = 0;

  function tickAt(times, t) {
    var low = 0, high = times.length - 1;
    while (low < high) {
      var middle = (low + high + 1) >> 1;
      if (times[middle] <= t + 1e-9) low = middle; else high = middle - 1;
    }
    return low;
  }
  function cones(ranges) {
    return run.sonars.map(function (sonar, k) {
      if (ranges[k] < 0) return "";
      var r = ranges[k] / 100, from = sonar[2] - sonar[3] / 2, to = sonar[2] + sonar[3] / 2;
      function at(angle) {
        return (sonar[0] + r * Math.cos(angle)).toFixed(3) + " " +
          (-sonar[1] - r * Math.sin(angle)).toFixed(3);
      }
      return "M" + sonar[0] + " " + -sonar[1] + "L" + at(from) + "A" + r + " " + r + " 0 0 0 " +
        at(to) + "Z";
    }).join("") || "M0 0";
  }
  function show(t) {
    time = Math.max(0, Math.min(run.end_s, t));
    slider.value = time;
    var share = run.end_s ? time / run.end_s : 0;
    charts.forEach(function (chart) {
      var left = +chart.dataset.left, right = +chart.dataset.right;
      var line = chart.querySelector(".cursor");
      if (line) line.setAttribute("transform", "translate(" + (left + (right - left) * share) + " 0)");
    });
    heats.forEach(function (heat) { heat.querySelector(".cursorbar").style.left = 100 * share + "%"; });
    run.robots.forEach(function (robot, number) {
      var i = tickAt(robot.t, time), mode = run.modes[robot.mode[i]], body = bodies[number];
      body.setAttribute("class", "robot " + mode);
      body.setAttribute("transform", "translate(" + robot.x[i] + " " + -robot.y[i] + ") rotate(" +
        (-robot.h[i] * 180 / Math.PI).toFixed(1) + ")");
      if (robot.echoes) body.querySelector(".cones").setAttribute("d", cones(robot.echoes[i]));
      if (number === 0) {
        output.textContent = time.toFixed(1) + " s  " + robot.v[i].toFixed(2) + " m/s";
        now.className = "now " + mode;
        now.querySelector("b").textContent = run.names[mode] || mode;
        now.querySelector("span").textContent = run.sentences[robot.said[i]];
      }
    });
  }
  function step(stamp) {
    if (!going) return;
    if (last) show(time + speed * (stamp - last) / 1000);
    last = stamp;
    if (time >= run.end_s) stop(); else requestAnimationFrame(step);
  }
  function stop() { going = false; play.textContent = "▶ play"; }
  function start() {
    if (time >= run.end_s) show(0);
    going = true; last = 0; play.textContent = "❚❚ pause"; requestAnimationFrame(step);
  }
  play.addEventListener("click", function () { if (going) stop(); else start(); });
  pace.addEventListener("click", function () {
    speed = speeds[(speeds.indexOf(speed) + 1) % speeds.length]; pace.textContent = "× " + speed;
  });
  slider.addEventListener("input", function () { stop(); show(+slider.value); });
  charts.forEach(function (chart) {
    chart.addEventListener("pointermove", function (event) {
      if (going) return;
      var box = chart.getBoundingClientRect();
      var x = (event.clientX - box.left) / box.width * 1000;
      var left = +chart.dataset.left, right = +chart.dataset.right;
      show((x - left) / (right - left) * run.end_s);
    });
  });
  heats.forEach(function (heat) {
    heat.addEventListener("pointermove", function (event) {
      if (going) return;
      var box = heat.getBoundingClientRect();
      show((event.clientX - box.left) / box.width * run.end_s);
    });
  });
  document.querySelectorAll("[data-time]").forEach(function (one) {
    one.addEventListener("click", function () { stop(); show(+one.dataset.time); });
  });
  document.addEventListener("keydown", function (event) {
    if (event.target.tagName === "BUTTON" || event.target.tagName === "SUMMARY") return;
    if (event.key === " ") { event.preventDefault(); if (going) stop(); else start(); }
    if (event.target.tagName === "INPUT") return;
    if (event.key === "ArrowLeft") show(time - 1);
    if (event.key === "ArrowRight") show(time + 1);
  });
  bar.hidden = false;
  show(run.end_s);
})();
