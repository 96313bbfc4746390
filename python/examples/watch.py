# SPDX-License-Identifier: BSD-3-Clause
import asyncio
import sys

import cas


async def watch(address):
    """Prints the vehicle's texts and its position until it reports that it has landed."""
    async with await cas.AsyncCasd.connect(address) as casd:
        async def print_places():
            while True:
                if (await casd.status())["vehicles"]:
                    now = await casd.vehicle.telemetry()
                    print(now["state"]["mode"], now["state"]["landed"], now["position"]["down_m"])
                await asyncio.sleep(0.2)

        places = asyncio.create_task(print_places())
        async for text in await casd.topics.statustext():
            print(f"vehicle {text['vehicle']}, {text['severity']}: {text['text']}")
            if text["text"].startswith("Land"):  # "Landed", and PX4's "Landing detected"
                break
        places.cancel()


def a_flight(bench):
    bench.arm()
    bench.takeoff(2.0)
    bench.run_for(2.0)
    bench.land()


if len(sys.argv) > 1:  # of a casd that runs already: its socket, or HOST:PORT
    asyncio.run(watch(sys.argv[1]))
else:
    async def both():
        with cas.Bench() as bench:
            await asyncio.gather(watch(bench.casd.client.address), asyncio.to_thread(a_flight, bench))

    asyncio.run(both())
