// Memory of the npm package, in a process of its own: the heap never shrinks, so other tests would leave room in it.
import assert from "node:assert/strict";
import test from "node:test";

import { fracture, heapBytes, shape } from "../../build/web/brittle-fracture/brittle.js";

test("memory stays constant over 1,000 fractures", async () => {
    const cube = await shape("cube");
    const work = async (times) => {
        for (let seed = 0; seed < times; ++seed) {
            const broken = await fracture(cube, { sites: 8, seed });
            assert.ok(broken.surface(0).length > 0);
            broken.dispose();
        }
    };
    await work(100);
    const before = heapBytes();
    await work(1000);
    assert.equal(heapBytes(), before);
    const kept = []; // without dispose() the same work needs more
    for (let seed = 0; seed < 3000; ++seed) kept.push(await fracture(cube, { sites: 8, seed }));
    assert.ok(heapBytes() > before);
    for (const broken of kept) broken.dispose();
});
