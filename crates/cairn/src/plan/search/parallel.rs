use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::buckets::Buckets;
use super::incoming::Incoming;
use super::label::{Label, Width};

/// Delta-stepping [Meyer03] on several threads: bucket after bucket, the nodes of one handed out in
/// chunks, each thread lowering shared costs and queueing what it lowered by itself. A thread whose own
/// share of the bucket is small goes on with it without waiting for the others [Zhang20].
///
/// Costs only ever fall to that of a real way, and every node is looked at again at its last cost: the
/// least fixed point is reached in whatever order the threads run. Pointers are left to
/// [`policy`](super::policy()). Returns the cost-to-go of every node; None if a sum did not fit `W`.
pub fn search<W: Label>(graph: &Incoming<W>, goals: &[u32], threads: usize) -> Option<Vec<W>> {
    let width = Width::about(graph.mean * MEANS_PER_BUCKET);
    let shared: Vec<W::Shared> = (0..graph.nodes()).map(|_| W::UNREACHABLE.shared()).collect();
    for &goal in goals {
        W::ZERO.lower(&shared[goal as usize]);
    }
    let round = Round {
        chunks: (0..threads).map(|_| Mutex::default()).collect(),
        least: std::array::from_fn(|_| AtomicU64::new(u64::MAX)),
        empty: std::array::from_fn(|_| AtomicBool::new(true)),
        barrier: Barrier::new(threads),
        overflow: AtomicBool::new(false),
    };
    round.chunks(0).push(goals.iter().map(|&goal| (W::ZERO, goal)).collect());
    std::thread::scope(|scope| {
        let (shared, round) = (&*shared, &round);
        let work = |number| Worker { number, graph, shared, width, queue: Buckets::new(), round }.run();
        (1..threads).for_each(|number| drop(scope.spawn(move || work(number))));
        work(0);
    });
    let fits = !round.overflow.load(Ordering::Relaxed);
    fits.then(|| shared.iter().map(W::load).collect())
}

/// Length of a bucket in mean links: longer than for one thread, so that threads meet less often.
const MEANS_PER_BUCKET: f64 = 1.0;
/// Nodes handed out at once.
const CHUNK: usize = 256;
/// A share of the bucket up to this long is gone on with at once.
const OWN_SHARE: usize = 1024;

/// A cost and the node that has it, or has by now a lesser one.
type Entry<W> = (W, u32);

/// What the threads tell one another.
struct Round<W> {
    /// Nodes of the current bucket that nobody has taken yet, by the thread that queued them.
    chunks: Vec<Mutex<Vec<Vec<Entry<W>>>>>,
    /// A bucket that nothing queued is below, of this round, the last and the next.
    least: [AtomicU64; 3],
    /// Whether nothing is queued.
    empty: [AtomicBool; 3],
    barrier: Barrier,
    overflow: AtomicBool,
}

impl<W> Round<W> {
    fn chunks(&self, thread: usize) -> MutexGuard<'_, Vec<Vec<Entry<W>>>> {
        self.chunks[thread].lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The newest chunk of this thread, or the oldest of another: what lies together stays together.
    fn take(&self, thread: usize) -> Option<Vec<Entry<W>>> {
        let own = self.chunks(thread).pop();
        own.or_else(|| {
            let threads = self.chunks.len();
            (1..threads).find_map(|ahead| {
                let mut others = self.chunks((thread + ahead) % threads);
                (!others.is_empty()).then(|| others.remove(0))
            })
        })
    }
}

struct Worker<'a, W: Label> {
    number: usize,
    graph: &'a Incoming<W>,
    shared: &'a [W::Shared],
    width: Width,
    /// What this thread lowered.
    queue: Buckets<Entry<W>>,
    round: &'a Round<W>,
}

impl<W: Label> Worker<'_, W> {
    fn run(mut self) {
        let (round, width) = (self.round, self.width);
        let mut batch = Vec::new();
        for slot in [0, 1, 2].into_iter().cycle() {
            while let Some(chunk) = round.take(self.number) {
                self.lower_before(&chunk);
            }
            while self.queue.waiting() <= OWN_SHARE && self.queue.take(&mut batch) {
                self.lower_before(&batch);
                batch.clear();
            }
            if let Some(least) = self.queue.least() {
                round.least[slot].fetch_min(least, Ordering::Relaxed);
                round.empty[slot].store(false, Ordering::Relaxed);
            }
            round.barrier.wait();
            if round.empty[slot].load(Ordering::Relaxed) {
                return;
            }
            // All have read the last round's by now, and write the round's after next after this one's.
            let last = (slot + 2) % 3;
            round.least[last].store(u64::MAX, Ordering::Relaxed);
            round.empty[last].store(true, Ordering::Relaxed);
            self.queue.move_to(round.least[slot].load(Ordering::Relaxed), |&(value, _)| value.bucket(width));
            if self.queue.take(&mut batch) {
                round.chunks(self.number).extend(batch.chunks(CHUNK).map(<[_]>::to_vec));
                batch.clear();
            }
        }
    }

    /// Lowers the nodes before each of `entries`.
    fn lower_before(&mut self, entries: &[Entry<W>]) {
        for &(value, node) in entries {
            if W::load(&self.shared[node as usize]) < value {
                continue; // lowered since: looked at again under its new cost
            }
            for &(from, cost) in self.graph.into(node) {
                let Some(candidate) = value.plus(cost) else {
                    self.round.overflow.store(true, Ordering::Relaxed);
                    continue;
                };
                if candidate.lower(&self.shared[from as usize]) {
                    self.queue.push(candidate.bucket(self.width), (candidate, from));
                }
            }
        }
    }
}

/// A barrier for waits of less than a microsecond: spins a while before it gives its core away.
struct Barrier {
    threads: usize,
    arrived: AtomicUsize,
    generation: AtomicUsize,
}

impl Barrier {
    fn new(threads: usize) -> Self {
        Self { threads, arrived: AtomicUsize::new(0), generation: AtomicUsize::new(0) }
    }

    fn wait(&self) {
        let generation = self.generation.load(Ordering::Acquire);
        if self.arrived.fetch_add(1, Ordering::AcqRel) + 1 == self.threads {
            self.arrived.store(0, Ordering::Relaxed);
            self.generation.store(generation.wrapping_add(1), Ordering::Release);
            return;
        }
        let mut turns = 0_u32;
        while self.generation.load(Ordering::Acquire) == generation {
            turns += 1;
            if turns < 2000 { std::hint::spin_loop() } else { std::thread::yield_now() }
        }
    }
}
